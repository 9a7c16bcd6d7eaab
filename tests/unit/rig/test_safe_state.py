"""Making safe: in the station's order, each read back, whatever fails."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import pytest

from helpers_devices import DRIVES, FakeTester
from rigrunner.api.calling import ThreadCaller
from rigrunner.api.errors import DeviceLostError, DeviceTimeoutError
from rigrunner.api.member import Member
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Patience, Rig
from rigrunner.rig.safe_state import NoRigError

OTHER_DRIVES = (replace(DRIVES[0], name="heater", safe_value=20.0, maximum=200.0),)


class Oven(FakeTester):
    """A second device, without a cyclic motion."""

    def __init__(self, log: list[str], **more: object) -> None:
        super().__init__(**more)
        self.log, self.drives, self.drives_at = log, OTHER_DRIVES, {"heater": 90.0}

    def _record_call(self, call: str) -> None:
        self.log.append(f"oven {call}")
        super()._record_call(call)

    def make_safe(self):
        self._record_call("make_safe")
        self.drives_at["heater"] = 20.0
        return dict(self.drives_at)


class Bench(FakeTester):
    def __init__(self, log: list[str], **more: object) -> None:
        super().__init__(**more)
        self.log = log

    def _record_call(self, call: str) -> None:
        self.log.append(f"tester {call}")
        super()._record_call(call)


def make_rig_safe(order, **more):
    """Return the calls of the devices in their order, and the reports."""
    calls: list[str] = []
    rig = Rig(
        {"oven": Oven(calls), "tester": Bench(calls, **more)},
        SimulatedClock(),
        Patience(answer_s=1.0),
        order,
    )
    rig.connect()
    calls.clear()
    reports = rig.make_safe()
    return [call for call in calls if "read_back" not in call], reports


def test_device_with_cycles_is_made_safe_first_by_default():
    calls, reports = make_rig_safe(())
    assert calls == ["tester make_safe", "oven make_safe"]
    assert [(report.what, report.safe) for report in reports] == [("tester", True), ("oven", True)]


def test_order_of_station_may_contain_drives_and_devices():
    calls, reports = make_rig_safe(
        (Member("tester", "frequency"), "oven", Member("tester", "load"))
    )
    assert calls == [
        "tester set frequency 0",
        "oven make_safe",
        "tester set load 0",
        "tester make_safe",
    ]
    what = [report.what for report in reports]
    assert what == ["tester.frequency", "oven", "tester.load", "tester"]
    assert reports[0].read_back == {"frequency": 0.0}


@pytest.mark.parametrize("error", [DeviceLostError("cable"), ZeroDivisionError("bug")])
def test_failing_drive_does_not_stop_the_next(error):
    def refuse(call):
        if call == "set frequency 0":
            raise error

    calls, reports = make_rig_safe(
        (Member("tester", "frequency"), Member("tester", "load")), before=refuse
    )
    assert calls == [
        "tester set frequency 0",
        "tester set load 0",
        "tester make_safe",
        "oven make_safe",
    ]
    assert [report.safe for report in reports] == [False, True, True, True]


def test_hanging_drive_is_abandoned_and_others_follow():
    release = threading.Event()

    def hang(call):
        if call == "set frequency 0":
            release.wait()

    calls: list[str] = []
    tester = Bench(calls, before=hang, non_blocking=False)
    tester.drives = tuple(replace(info, rate_per_s=None) for info in DRIVES)
    rig = Rig(
        {"oven": Oven(calls), "tester": tester},
        SimulatedClock(),
        Patience(answer_s=1.0),
        (Member("tester", "frequency"), Member("tester", "load")),
    )
    rig.connect()
    rig._roles["tester"].caller.grace_s = 0.02
    reports = rig.make_safe()
    release.set()
    assert [(report.what, report.safe) for report in reports] == [
        ("tester.frequency", False),
        ("tester.load", True),
        ("tester", True),
        ("oven", True),
    ]
    assert "'make safe' did not return within 1 s" in reports[0].problems[0]
    rig.close()


@pytest.mark.parametrize("order", [(), ("tester",), (Member("tester", "frequency"),)])
def test_devices_do_not_wait_for_one_that_does_not_confirm(order):
    """The tester confirms only after the oven was made safe."""
    oven_is_safe = threading.Event()

    def slow(call):
        if call == "make_safe":
            assert oven_is_safe.wait(20.0)

    class SignallingOven(Oven):
        def make_safe(self):
            read_back = super().make_safe()
            oven_is_safe.set()
            return read_back

    calls: list[str] = []
    devices = {
        "oven": SignallingOven(calls, non_blocking=False),
        "tester": Bench(calls, before=slow, non_blocking=False),
    }
    rig = Rig(devices, SimulatedClock(), Patience(answer_s=1.0), order)
    rig.connect()
    reports = {report.what: report for report in rig.make_safe()}
    assert reports["tester"].safe
    assert reports["oven"].safe
    rig.close()


def test_drive_with_unsafe_read_back_is_not_safe():
    _, reports = make_rig_safe((Member("tester", "frequency"),), read_back_offset=0.5)
    assert reports[0].problems == ("frequency reads back 0.5 Hz, safe is 0 Hz",)


def test_drives_of_unconnected_device_are_left_to_its_make_safe():
    calls: list[str] = []
    rig = Rig({"tester": Bench(calls)}, SimulatedClock(), None, (Member("tester", "frequency"),))
    assert [report.what for report in rig.make_safe()] == ["tester"]
    assert calls == ["tester make_safe"]


def test_unconnected_device_is_not_set_drive_by_drive():
    tester = StopsHalfWay(DeviceLostError("not connected"))
    (report,) = Rig({"tester": tester}, SimulatedClock()).make_safe()
    assert not report.safe
    assert tester.calls == []


def test_ordered_drive_is_set_to_its_safe_value():
    calls, reports = make_rig_safe((Member("oven", "heater"),))
    assert calls[0] == "oven set heater 20"
    assert reports[0].read_back == {"heater": 20.0}


@pytest.mark.parametrize("fails", [False, True])
def test_making_safe_has_time_for_its_drives(fails):
    class Slow(FakeTester):
        def make_safe(self):
            if fails:
                raise DeviceLostError("half way")
            time.sleep(0.8)
            return super().make_safe()

        def set(self, drive, value):
            time.sleep(0.8 if drive == "load" and fails else 0.0)
            super().set(drive, value)

    drives = (replace(DRIVES[0], rate_per_s=None, settle_s=5.0), DRIVES[1])
    slow = Slow(non_blocking=False, drives=drives)
    rig = Rig({"tester": slow}, SimulatedClock(), Patience(answer_s=0.5))
    rig.connect()
    (report,) = rig.make_safe()
    assert report.read_back == {"load": 0.0, "frequency": 0.0}
    assert report.problems == (("make safe failed: half way",) if fails else ())
    rig.close()


class Late(FakeTester):
    """A tester whose 'set load 1000' reaches the drive only once it is released."""

    def __init__(self, **more: object) -> None:
        super().__init__(non_blocking=False, **more)
        self.release = threading.Event()

    def set(self, drive, value):
        if value:
            self.release.wait(10)
        super().set(drive, value)


class LateToBegin(Late):
    """The same for a device with `begin` and `arrived`."""

    def begin(self, drive, value):
        self.set(drive, value)

    def arrived(self, _drive):
        return True


@pytest.fixture(params=[Late, LateToBegin])
def late(request, monkeypatch):
    """Yield a tester with an abandoned set, and its rig."""
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    tester = request.param()
    rig = rig_with_abandoned_set(tester)
    yield tester, rig
    tester.release.set()
    rig.close()


def rig_with_abandoned_set(tester, order=()):
    tester.drives = tuple(replace(info, rate_per_s=None) for info in DRIVES)
    rig = Rig({"tester": tester}, SimulatedClock(), Patience(answer_s=0.5), order)
    rig.connect()
    with pytest.raises(DeviceTimeoutError, match="'set load' did not return"):
        rig.set("tester", "load", 1000.0)
    return rig


def test_device_is_made_safe_again_after_late_set(late, monkeypatch):
    tester, rig = late

    def with_late_set(self):
        safe = FakeTester.make_safe(self)
        if not self.release.is_set():
            self.release.set()
            while self.drives_at["load"] != 1000.0:
                time.sleep(0.001)
        return safe

    monkeypatch.setattr(Late, "make_safe", with_late_set)
    (report,) = rig.make_safe()
    assert report.safe
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}
    assert tester.calls.count("make_safe") == 2


def test_hanging_set_leaves_rig_not_safe(late):
    tester, rig = late
    (report,) = rig.make_safe()
    assert report.read_back == {"load": 0.0, "frequency": 0.0}
    assert report.problems == (
        "'set load' was given up and has not come back: it may still move the drive",
    )
    tester.release.set()
    while tester.drives_at["load"] != 1000.0:
        time.sleep(0.001)
    (report,) = rig.make_safe()
    assert report.safe
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}


def test_hanging_set_is_reported_once_for_the_device(monkeypatch):
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    tester = Late()
    rig = rig_with_abandoned_set(tester, (Member("tester", "load"),))
    drive_report, device_report = rig.make_safe()
    assert (drive_report.what, drive_report.problems) == ("tester.load", ())
    assert (device_report.what, len(device_report.problems)) == ("tester", 1)
    tester.release.set()
    rig.close()


def test_hanging_set_is_reported_even_after_refused_teardown(late):
    tester, rig = late
    for drive in ("frequency", "load"):
        with pytest.raises(DeviceLostError, match="still hangs"):
            rig.set("tester", drive, 0.0)
    (report,) = rig.make_safe()
    assert report.problems == (
        "'set load' was given up and has not come back: it may still move the drive",
    )
    tester.release.set()


class StopsHalfWay(FakeTester):
    """A driver whose `make_safe` stops at the first drive that fails."""

    def __init__(self, error: BaseException, **more: object) -> None:
        super().__init__(**more)
        self.error = error
        self.raised = 0

    def make_safe(self):
        self.raised += 1
        raise self.error


@pytest.mark.parametrize("non_blocking", [True, False])
@pytest.mark.parametrize("error", [IndexError("bug"), SystemExit(1), DeviceLostError("cable")])
def test_drives_are_set_one_by_one_if_make_safe_raises(error, non_blocking):
    calls: list[str] = []
    tester = StopsHalfWay(error, non_blocking=non_blocking)
    rig = Rig({"tester": tester, "oven": Oven(calls)}, SimulatedClock(), Patience(answer_s=5.0))
    rig.connect()
    rig.set("tester", "frequency", 10.0)
    rig.set("tester", "load", 500.0)
    reports = rig.make_safe()
    assert tester.drives_at == {"frequency": 0.0, "load": 0.0}
    assert calls[-1] == "oven make_safe"
    report = next(report for report in reports if report.role == "tester")
    assert report.read_back == {"frequency": 0.0, "load": 0.0}
    assert len(report.problems) == 1  # the device did not confirm all that it does to be safe
    assert str(error) in report.problems[0]
    rig.close()


def test_hanging_ordered_device_does_not_delay_others():
    oven_is_safe, release = threading.Event(), threading.Event()

    class Hangs(FakeTester):
        def make_safe(self):
            release.wait(20.0)

        def set(self, drive, value):
            assert not self.drives_at["load"] or value or oven_is_safe.wait(0.5)
            super().set(drive, value)

    class SignallingOven(Oven):
        def make_safe(self):
            oven_is_safe.set()
            return super().make_safe()

    devices = {"tester": Hangs(non_blocking=False), "oven": SignallingOven([], non_blocking=False)}
    rig = Rig(devices, SimulatedClock(), Patience(answer_s=1.0), ("tester",))
    rig.connect()
    tester, oven = rig.make_safe()
    release.set()
    assert oven.safe
    assert tester.read_back == {"load": 0.0, "frequency": 0.0}
    rig.close()


def test_failing_ordered_device_is_set_drive_by_drive_only_in_second_turn():
    class Fails(Bench):
        def make_safe(self):
            self._record_call("make_safe")
            raise IndexError("bug")

    calls: list[str] = []
    rig = Rig({"tester": Fails(calls), "oven": Oven(calls)}, SimulatedClock(), None, ("tester",))
    rig.connect()
    calls.clear()
    rig.make_safe()
    assert [call for call in calls if "read_back" not in call] == [
        "tester make_safe",
        "tester make_safe",
        "tester set load 0",
        "tester set frequency 0",
        "oven make_safe",
    ]


def test_interrupts_abandon_device_that_never_answers(monkeypatch):
    """With unlimited patience nothing else would end the wait: the third one does."""
    release, interrupts = threading.Event(), iter(range(3))
    real = threading.Thread.join

    def join(thread, timeout=None):
        if thread.name == "make safe tester" and next(interrupts, None) is not None:
            raise KeyboardInterrupt
        real(thread, timeout)

    devices = {
        "tester": FakeTester(non_blocking=False, before=lambda _: release.wait(20.0)),
        "oven": Oven([]),
    }
    rig = Rig(devices, SimulatedClock(), Patience(answer_s=float("inf")))
    monkeypatch.setattr(threading.Thread, "join", join)
    tester, oven = rig.make_safe()
    release.set()
    assert next(interrupts, None) is None
    assert tester.problems == ("make safe was interrupted from the keyboard",)
    assert oven.safe


def test_devices_are_made_safe_without_new_threads(monkeypatch):
    real = threading.Thread.start

    def start(thread):
        if thread.name.startswith("make safe"):
            raise RuntimeError("can't start new thread")
        real(thread)

    monkeypatch.setattr(threading.Thread, "start", start)
    rig = Rig({"tester": FakeTester(non_blocking=False), "oven": Oven([])}, SimulatedClock())
    rig.connect()
    assert [report.safe for report in rig.make_safe()] == [True, True]
    rig.close()


def test_differing_replay_sets_no_drive():
    tester = StopsHalfWay(NoRigError("the tape has no answer"))
    rig = Rig({"tester": tester}, SimulatedClock())
    rig.connect()
    tester.calls.clear()
    (report,) = rig.make_safe()
    assert not report.there
    assert report.problems == ("make safe failed: the tape has no answer",)
    assert tester.calls == []


def test_drive_without_read_back_is_left_to_its_device():
    class Blind(FakeTester):
        read_back = None

    tester = Blind()
    rig = Rig({"tester": tester}, SimulatedClock(), None, (Member("tester", "load"),))
    rig.connect()
    tester.calls.clear()
    drive_report, device_report = rig.make_safe()
    assert drive_report.problems == ("make safe failed: there is no drive 'load' that can be set",)
    assert device_report.safe
    assert tester.calls == ["make_safe"]


def test_device_that_cannot_be_set_is_not_set_drive_by_drive():
    class Blind(StopsHalfWay):
        read_back = None

    rig = Rig({"tester": Blind(DeviceLostError("cable"))}, SimulatedClock())
    rig.connect()
    (report,) = rig.make_safe()
    assert report.problems == ("make safe failed: cable",)


def test_failing_drive_does_not_stop_setting_one_by_one():
    tester = StopsHalfWay(IndexError("bug"))
    rig = Rig({"tester": tester}, SimulatedClock())
    rig.connect()
    rig.set("tester", "load", 500.0)

    def refuse(call):
        if call.startswith("set frequency"):
            raise ZeroDivisionError("no rate")

    tester.before = refuse
    (report,) = rig.make_safe()
    assert tester.drives_at["load"] == 0.0
    assert report.read_back == {"load": 0.0}
    assert "frequency cannot be made safe: ZeroDivisionError: no rate" in report.problems[1]


def test_drive_set_by_itself_is_reported_with_unsafe_read_back():
    tester = StopsHalfWay(IndexError("bug"), read_back_offset=50.0)
    rig = Rig({"tester": tester}, SimulatedClock())
    rig.connect()
    (report,) = rig.make_safe()
    assert not report.safe
    assert "load reads back 50 N, safe is 0 N" in report.problems


def test_ctrl_c_while_setting_one_by_one_restarts_making_safe():
    tester = StopsHalfWay(IndexError("bug"))
    rig = Rig({"tester": tester}, SimulatedClock())
    rig.connect()
    rig.set("tester", "load", 500.0)
    presses = iter([KeyboardInterrupt])

    def press(call):
        if call.startswith("set load"):
            for press in presses:
                raise press

    tester.before = press
    (report,) = rig.make_safe()
    assert tester.raised == 2
    assert report.read_back == {"load": 0.0, "frequency": 0.0}


@pytest.mark.parametrize(
    "error", [AttributeError("no drives"), SystemExit(1), KeyboardInterrupt()], ids=repr
)
def test_device_that_cannot_list_its_drives_is_reported(error):
    class Mute(FakeTester):
        broken = False

        def __getattribute__(self, name):
            if name == "drives" and object.__getattribute__(self, "broken"):
                raise error
            return super().__getattribute__(name)

    calls: list[str] = []
    mute = Mute()
    rig = Rig({"mute": mute, "oven": Oven(calls)}, SimulatedClock())
    rig.connect()
    mute.broken = True
    try:
        reports = {report.role: report for report in rig.make_safe()}
    finally:
        mute.broken = False  # pytest looks at it, should this fail
    assert calls[-1] == "oven make_safe"
    assert reports["oven"].safe
    assert not reports["mute"].safe
    if not isinstance(error, KeyboardInterrupt):
        assert mute.calls[-1] == "make_safe"
        assert mute.drives_at == {"load": 0.0, "frequency": 0.0}
        (problem,) = reports["mute"].problems
        assert problem.startswith("its drives cannot be listed: ")


def test_all_devices_are_closed_even_if_one_raises():
    class Ends(FakeTester):
        def close(self):
            raise SystemExit(1)

    class Closes(FakeTester):
        closed = False

        def close(self):
            self.closed = True

    last = Closes()
    rig = Rig({"ends": Ends(), "last": last}, SimulatedClock())
    rig.connect()
    with pytest.raises(RuntimeError, match="ends"):
        rig.close()
    assert last.closed


def test_unknown_ordered_drive_is_reported_and_others_are_made_safe():
    calls, reports = make_rig_safe((Member("tester", "laod"), Member("tester", "load")))
    assert reports[0].problems == ("make safe failed: there is no drive 'laod' that can be set",)
    assert calls[0] == "tester set load 0"
    assert [report.safe for report in reports] == [False, True, True, True]


def test_set_returning_during_the_wait_is_followed_by_making_safe_again(late, monkeypatch):
    tester, rig = late
    rig._roles["tester"].caller.grace_s = 0.05
    monkeypatch.setattr(ThreadCaller, "grace_s", 10.0)
    monkeypatch.setattr(Late, "make_safe", make_safe_then_release)
    (report,) = rig.make_safe()
    assert report.safe
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}


def make_safe_then_release(tester):
    """Make safe; a moment later the abandoned set continues."""
    safe = FakeTester.make_safe(tester)
    threading.Timer(0.05, tester.release.set).start()
    return safe
