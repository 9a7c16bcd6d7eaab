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
    """A second device, without a motion in cycles."""

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


def made_safe(order, **more):
    """Return what the devices were told in which order, and the reports."""
    calls: list[str] = []
    rig = Rig(
        {"oven": Oven(calls), "tester": Bench(calls, **more)},
        SimulatedClock(),
        Patience(answer_s=0.05),
        order,
    )
    rig.connect()
    calls.clear()
    reports = rig.make_safe()
    return [call for call in calls if "read_back" not in call], reports


def test_unless_told_what_moves_in_cycles_is_made_safe_first():
    calls, reports = made_safe(())
    assert calls == ["tester make_safe", "oven make_safe"]
    assert [(report.what, report.safe) for report in reports] == [("tester", True), ("oven", True)]


def test_the_stations_order_goes_through_drives_and_devices():
    calls, reports = made_safe((Member("tester", "frequency"), "oven", Member("tester", "load")))
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
def test_a_drive_that_fails_does_not_stop_the_next(error):
    def refuse(call):
        if call == "set frequency 0":
            raise error

    calls, reports = made_safe(
        (Member("tester", "frequency"), Member("tester", "load")), before=refuse
    )
    assert calls == [
        "tester set frequency 0",
        "tester set load 0",
        "tester make_safe",
        "oven make_safe",
    ]
    assert [report.safe for report in reports] == [False, True, True, True]


def test_a_drive_that_hangs_is_abandoned_and_the_others_follow():
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
        Patience(answer_s=0.05),
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
    assert "'make safe' did not return within 0.05 s" in reports[0].problems[0]
    rig.close()


@pytest.mark.parametrize("order", [(), ("tester",), (Member("tester", "frequency"),)])
def test_no_device_waits_for_one_that_does_not_confirm_that_it_is_safe(order):
    """The tester stands safe only once the oven has been told to be."""
    oven_is_safe = threading.Event()

    def slow(call):
        if call == "make_safe":
            assert oven_is_safe.wait(20.0)

    class OvenThatTells(Oven):
        def make_safe(self):
            read_back = super().make_safe()
            oven_is_safe.set()
            return read_back

    calls: list[str] = []
    devices = {
        "oven": OvenThatTells(calls, non_blocking=False),
        "tester": Bench(calls, before=slow, non_blocking=False),
    }
    rig = Rig(devices, SimulatedClock(), Patience(answer_s=1.0), order)
    rig.connect()
    reports = {report.what: report for report in rig.make_safe()}
    assert reports["tester"].safe
    assert reports["oven"].safe
    rig.close()


def test_a_drive_that_reads_back_something_else_is_not_safe():
    _, reports = made_safe((Member("tester", "frequency"),), read_back_offset=0.5)
    assert reports[0].problems == ("frequency reads back 0.5 Hz, safe is 0 Hz",)


def test_drives_of_a_device_that_never_answered_are_left_to_its_own_make_safe():
    calls: list[str] = []
    rig = Rig({"tester": Bench(calls)}, SimulatedClock(), None, (Member("tester", "frequency"),))
    assert [report.what for report in rig.make_safe()] == ["tester"]
    assert calls == ["tester make_safe"]


def test_a_device_that_was_not_connected_is_not_set_drive_by_drive():
    tester = StopsHalfWay(DeviceLostError("not connected"))
    (report,) = Rig({"tester": tester}, SimulatedClock()).make_safe()
    assert not report.safe
    assert tester.calls == []


def test_a_drive_of_the_order_is_set_to_its_own_safe_value():
    calls, reports = made_safe((Member("oven", "heater"),))
    assert calls[0] == "oven set heater 20"
    assert reports[0].read_back == {"heater": 20.0}


@pytest.mark.parametrize("fails", [False, True])
def test_making_safe_has_the_time_that_the_drives_need(fails):
    class Slow(FakeTester):
        def make_safe(self):
            if fails:
                raise DeviceLostError("half way")
            time.sleep(0.3)
            return super().make_safe()

        def set(self, drive, value):
            time.sleep(0.3 if drive == "load" and fails else 0.0)
            super().set(drive, value)

    drives = (replace(DRIVES[0], rate_per_s=None, settle_s=5.0), DRIVES[1])
    slow = Slow(non_blocking=False, drives=drives)
    rig = Rig({"tester": slow}, SimulatedClock(), Patience(answer_s=0.05))
    rig.connect()
    (report,) = rig.make_safe()
    assert report.read_back == {"load": 0.0, "frequency": 0.0}
    assert report.problems == (("make safe failed: half way",) if fails else ())
    rig.close()


class Late(FakeTester):
    """A tester whose 'set load 1000' comes to the drive only once it is let go."""

    def __init__(self, **more: object) -> None:
        super().__init__(non_blocking=False, **more)
        self.let_go = threading.Event()

    def set(self, drive, value):
        if value:
            self.let_go.wait(10)
        super().set(drive, value)


class LateToBegin(Late):
    """The same for a device that is asked whether a drive has arrived."""

    def begin(self, drive, value):
        self.set(drive, value)

    def arrived(self, _drive):
        return True


@pytest.fixture(params=[Late, LateToBegin])
def late(request, monkeypatch):
    """Return a tester whose set was given up, and its rig."""
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    tester = request.param()
    rig = rig_that_gave_up_a_set(tester)
    yield tester, rig
    tester.let_go.set()
    rig.close()


def rig_that_gave_up_a_set(tester, order=()):
    tester.drives = tuple(replace(info, rate_per_s=None) for info in DRIVES)
    rig = Rig({"tester": tester}, SimulatedClock(), Patience(answer_s=0.5), order)
    rig.connect()
    with pytest.raises(DeviceTimeoutError, match="'set load' did not return"):
        rig.set("tester", "load", 1000.0)
    return rig


def test_behind_a_set_that_comes_late_the_device_is_made_safe_once_more(late, monkeypatch):
    tester, rig = late

    def then_the_late_one(self):
        safe = FakeTester.make_safe(self)
        if not self.let_go.is_set():
            self.let_go.set()
            while self.drives_at["load"] != 1000.0:
                time.sleep(0.001)
        return safe

    monkeypatch.setattr(Late, "make_safe", then_the_late_one)
    (report,) = rig.make_safe()
    assert report.safe
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}
    assert tester.calls.count("make_safe") == 2


def test_a_set_that_does_not_come_back_leaves_the_rig_not_safe(late):
    tester, rig = late
    (report,) = rig.make_safe()
    assert report.read_back == {"load": 0.0, "frequency": 0.0}
    assert report.problems == (
        "'set load' was given up and has not come back: it may still move the drive",
    )
    tester.let_go.set()
    while tester.drives_at["load"] != 1000.0:
        time.sleep(0.001)
    (report,) = rig.make_safe()
    assert report.safe
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}


def test_a_set_that_does_not_come_back_is_told_of_the_device_and_not_of_each_drive(monkeypatch):
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    tester = Late()
    rig = rig_that_gave_up_a_set(tester, (Member("tester", "load"),))
    of_drive, of_device = rig.make_safe()
    assert (of_drive.what, of_drive.problems) == ("tester.load", ())
    assert (of_device.what, len(of_device.problems)) == ("tester", 1)
    tester.let_go.set()
    rig.close()


def test_a_teardown_that_was_refused_hides_no_set_that_may_still_come(late):
    tester, rig = late
    for drive in ("frequency", "load"):
        with pytest.raises(DeviceLostError, match="still hangs"):
            rig.set("tester", drive, 0.0)
    (report,) = rig.make_safe()
    assert report.problems == (
        "'set load' was given up and has not come back: it may still move the drive",
    )
    tester.let_go.set()


class StopsHalfWay(FakeTester):
    """A driver of somebody's own, whose `make_safe` stops at the first drive that fails."""

    def __init__(self, error: BaseException, **more: object) -> None:
        super().__init__(**more)
        self.error = error
        self.raised = 0

    def make_safe(self):
        self.raised += 1
        raise self.error


@pytest.mark.parametrize("non_blocking", [True, False])
@pytest.mark.parametrize("error", [IndexError("bug"), SystemExit(1), DeviceLostError("cable")])
def test_what_make_safe_of_a_device_raises_keeps_no_drive_from_its_safe_value(error, non_blocking):
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


def test_a_device_of_the_order_that_hangs_is_set_drive_by_drive_only_beside_the_others():
    oven_is_safe, release = threading.Event(), threading.Event()

    class Hangs(FakeTester):
        def make_safe(self):
            release.wait(20.0)

        def set(self, drive, value):
            assert not self.drives_at["load"] or value or oven_is_safe.wait(0.5)
            super().set(drive, value)

    class OvenThatTells(Oven):
        def make_safe(self):
            oven_is_safe.set()
            return super().make_safe()

    devices = {"tester": Hangs(non_blocking=False), "oven": OvenThatTells([], non_blocking=False)}
    rig = Rig(devices, SimulatedClock(), Patience(answer_s=0.2), ("tester",))
    rig.connect()
    tester, oven = rig.make_safe()
    release.set()
    assert oven.safe
    assert tester.read_back == {"load": 0.0, "frequency": 0.0}
    rig.close()


def test_a_device_of_the_order_that_fails_is_set_drive_by_drive_in_its_second_turn_alone():
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


def test_an_impatient_person_leaves_what_never_answers(monkeypatch):
    """With patience without end nothing else would end the wait."""
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
    assert tester.problems == ("make safe was interrupted from the keyboard",)
    assert oven.safe


def test_without_a_thread_left_each_device_is_made_safe_all_the_same(monkeypatch):
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


def test_in_a_replay_that_is_out_of_step_no_drive_is_set_by_itself():
    tester = StopsHalfWay(NoRigError("the tape has no answer"))
    rig = Rig({"tester": tester}, SimulatedClock())
    rig.connect()
    tester.calls.clear()
    (report,) = rig.make_safe()
    assert not report.there
    assert report.problems == ("make safe failed: the tape has no answer",)
    assert tester.calls == []


def test_a_drive_that_cannot_be_read_back_is_not_set_but_left_to_its_device():
    class Blind(FakeTester):
        read_back = None

    tester = Blind()
    rig = Rig({"tester": tester}, SimulatedClock(), None, (Member("tester", "load"),))
    rig.connect()
    tester.calls.clear()
    of_drive, of_device = rig.make_safe()
    assert of_drive.problems == ("make safe failed: there is no drive 'load' that can be set",)
    assert of_device.safe
    assert tester.calls == ["make_safe"]


def test_a_drive_that_fails_by_itself_too_keeps_no_other_one():
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


def test_a_drive_that_stays_when_it_is_set_by_itself_is_told_with_its_value():
    tester = StopsHalfWay(IndexError("bug"), read_back_offset=50.0)
    rig = Rig({"tester": tester}, SimulatedClock())
    rig.connect()
    (report,) = rig.make_safe()
    assert not report.safe
    assert "load reads back 50 N, safe is 0 N" in report.problems


def test_ctrl_c_while_drives_are_set_one_by_one_begins_making_safe_anew():
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
def test_a_device_that_cannot_list_its_drives_is_reported_and_the_others_are_made_safe(error):
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


def test_every_device_is_closed_whatever_one_of_them_raises():
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


def test_a_drive_of_the_order_that_is_not_there_is_told_and_the_others_are_made_safe():
    calls, reports = made_safe((Member("tester", "laod"), Member("tester", "load")))
    assert reports[0].problems == ("make safe failed: there is no drive 'laod' that can be set",)
    assert calls[0] == "tester set load 0"
    assert [report.safe for report in reports] == [False, True, True, True]


def test_a_set_that_comes_back_while_it_is_waited_for_is_followed_by_making_safe_again(
    late, monkeypatch
):
    tester, rig = late
    rig._roles["tester"].caller.grace_s = 0.05
    monkeypatch.setattr(ThreadCaller, "grace_s", 10.0)
    monkeypatch.setattr(Late, "make_safe", released_soon)
    (report,) = rig.make_safe()
    assert report.safe
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}


def released_soon(tester):
    """Make safe; a moment later the set that was given up goes on."""
    safe = FakeTester.make_safe(tester)
    threading.Timer(0.05, tester.let_go.set).start()
    return safe
