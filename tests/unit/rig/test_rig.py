from __future__ import annotations

import threading
import time
from asyncio import CancelledError
from contextlib import closing
from decimal import Decimal

import numpy as np
import pytest

from helpers_devices import DRIVES, FakeTester, NthCall, samples_of
from rigrunner.api.devices import (
    Device,
    DriveInfo,
    Identity,
    KnowsTruth,
    Readable,
    ReadingInfo,
    Settable,
    Streaming,
)
from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
)
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Patience, Rig, SafetyReport
from rigrunner.rig.safe_state import note_unsafe

NEVER = threading.Event()


def rig_of(*devices: Device, **patience: float) -> Rig:
    roles = ("tester", "oven", "camera")
    return Rig(dict(zip(roles, devices, strict=False)), SimulatedClock(), Patience(**patience))


def raising(error: BaseException, *, at: str):
    def before(call: str) -> None:
        if call == at:
            raise error

    return before


def test_the_fake_is_a_device_with_all_abilities():
    for ability in (Device, Readable, Settable, Streaming, KnowsTruth):
        assert isinstance(FakeTester(), ability)


def test_connect_gives_who_answered():
    assert rig_of(FakeTester()).connect()["tester"].maker == "Fakes"


@pytest.mark.parametrize(
    "identity", [None, "ACME", Identity(None, "x", "1"), Identity("ACME", "x", 5)]
)
def test_who_answered_is_told_in_words(identity):
    tester = FakeTester()
    tester.connect = lambda _: identity
    with pytest.raises(DeviceRejectedError, match="tester: connect gave"):
        Rig({"tester": tester}, SimulatedClock()).connect()
    assert tester.calls == ["make_safe", "close"]


@pytest.mark.parametrize("non_blocking", [True, False])
@pytest.mark.parametrize("raised", [SystemExit(0), CancelledError()])
def test_a_driver_that_would_end_the_program_is_a_bug_of_it(raised, non_blocking):
    """Else the command would end with 0, as if all had been well."""

    def fail(call):
        if call.startswith("read "):
            raise raised

    tester = FakeTester(non_blocking=non_blocking, before=fail)
    rig = Rig({"tester": tester}, SimulatedClock())
    with rig, pytest.raises(RuntimeError, match=f"'read' raised {type(raised).__name__}"):
        rig.read("tester", ["torque"])


def test_what_a_driver_did_not_foresee_names_the_role():
    tester = FakeTester(before=NthCall(1, ValueError("oops")))
    rig = Rig({"tester": tester}, SimulatedClock())
    with rig, pytest.raises(ValueError, match="oops") as caught:
        rig.read("tester", ["torque"])
    assert caught.value.__notes__ == ["in the device of the role 'tester': read"]


def test_failed_connect_names_the_role_and_leaves_all_safe_and_closed():
    first = FakeTester()
    unplugged = FakeTester(before=raising(DeviceNotFoundError("nothing at COM3"), at="connect"))
    third = FakeTester()
    with pytest.raises(DeviceNotFoundError, match="oven: nothing at COM3"):
        rig_of(first, unplugged, third).connect()
    assert first.calls == ["connect", "make_safe", "close"]
    assert unplugged.calls == ["connect", "make_safe", "close"]
    assert "connect" not in third.calls


def test_a_device_that_does_not_become_safe_is_told_though_another_kept_the_rig_from_connecting():
    first = FakeTester(read_back_offset=50.0)
    unplugged = FakeTester(
        before=raising(DeviceNotFoundError("nothing at COM3"), at="connect"), read_back_offset=50.0
    )
    with pytest.raises(DeviceNotFoundError) as caught:
        rig_of(first, unplugged).connect()
    (note,) = caught.value.__notes__
    assert note.startswith("the rig is not safe: tester: load reads back 50 N, safe is 0 N; ")
    assert "oven" not in note, "one that does not answer is the error itself"


def test_error_while_closing_stands_beside_the_first_one():
    unplugged = FakeTester(before=raising(DeviceNotFoundError("nothing at COM3"), at="connect"))
    broken = FakeTester(before=raising(DeviceLostError("cable"), at="close"))
    with pytest.raises(DeviceNotFoundError) as caught:
        rig_of(unplugged, broken).connect()
    assert caught.value.__notes__ == ["closing the rig failed too: oven: cable"]


def test_set_gives_the_read_back():
    device = FakeTester(read_back_offset=-3.0)
    assert rig_of(device).set("tester", "load", 1000.0) == 997.0
    assert device.calls == ["set load 1000", "read_back load"]


@pytest.mark.parametrize("value", [-1.0, 3000.1, float("nan")])
def test_set_beyond_the_limits_never_reaches_the_device(value):
    device = FakeTester()
    with pytest.raises(
        DeviceRejectedError, match=r"tester: load: .* N is out of range .*0 to 3000"
    ):
        rig_of(device).set("tester", "load", value)
    assert device.calls == []


def test_read_back_beyond_one_percent_of_the_range_is_refused():
    device = FakeTester(read_back_offset=30.1)
    with pytest.raises(DeviceRejectedError, match=r"1000 N but reads back 1030.1 N .*within 30 N"):
        rig_of(device).set("tester", "load", 1000.0)


def test_a_read_back_that_is_no_number_is_refused():
    rig = rig_of(FakeTester(read_back_offset=float("nan")))
    rig.connect()
    with pytest.raises(DeviceRejectedError, match="was set to 100 N but reads back nan N"):
        rig.set("tester", "load", 100.0)


def test_declared_tolerance_counts():
    device = FakeTester(read_back_offset=0.6)
    device.drives = (DriveInfo("load", "N", "load", 0.0, 3000.0, tolerance=0.5),)
    with pytest.raises(DeviceRejectedError, match=r"within 0\.5 N"):
        rig_of(device).set("tester", "load", 1000.0)


def test_unknown_drive_and_missing_ability_are_told():
    class Mute(FakeTester):
        read_back = None

    with pytest.raises(DeviceRejectedError, match=r"no drive 'speed'.*there are: load, frequency"):
        rig_of(FakeTester()).set("tester", "speed", 1.0)
    with pytest.raises(DeviceRejectedError, match="tester: the device is not settable"):
        rig_of(Mute()).set("tester", "load", 1.0)


def test_conditions_are_all_that_can_be_read_but_the_streamed_channels():
    tester, oven = FakeTester(), FakeTester()
    values, units = rig_of(tester, oven).conditions("tester", ("angle", "torque"))
    assert set(values) == {"tester.load", "oven.angle", "oven.torque", "oven.load"}
    assert units["oven.torque"] == "N·m"
    assert tester.calls == ["read load"]


def test_condition_that_is_no_number_is_refused():
    with pytest.raises(DeviceRejectedError, match="tester: no value was read of load"):
        rig_of(FakeTester(read_back_offset=float("nan"))).conditions("tester", ("angle", "torque"))


@pytest.mark.parametrize("non_blocking", [True, False])
def test_stream_gives_the_blocks(non_blocking):
    device = FakeTester(non_blocking=non_blocking)
    rig = rig_of(device)
    blocks = list(rig.stream("tester", ("torque",), 0.25, NEVER))
    assert [block.samples for block in blocks] == [100, 100, 50]
    assert (blocks[2].channels["torque"] == samples_of("torque", 200, 50)).all()
    ours = threading.current_thread().name
    assert device.threads == {ours if non_blocking else "device tester"}
    rig.close()


@pytest.mark.parametrize("non_blocking", [True, False])
def test_stream_that_is_left_early_is_ended_on_the_device_before_anything_else(non_blocking):
    streams = []  # or else the collector of garbage might end the stream for us

    class Tidy(FakeTester):
        def stream(self, channels, duration_s, stop):
            streams.append(self._tidy(channels, duration_s, stop))
            return streams[0]

        def _tidy(self, channels, duration_s, stop):
            try:
                yield from super().stream(channels, duration_s, stop)
            finally:
                self._record_call("stream ended")

    device = Tidy(non_blocking=non_blocking)
    rig = rig_of(device)
    with closing(rig.stream("tester", ("torque",), 0.25, NEVER)) as blocks:
        next(blocks)
    rig.set("tester", "load", 0.0)
    assert device.calls == ["stream", "block", "stream ended", "set load 0", "read_back load"]
    assert len(device.threads) == 1
    rig.close()


@pytest.mark.parametrize("non_blocking", [True, False])
@pytest.mark.parametrize(
    ("raised", "kind", "message"),
    [
        (TimeoutError(), DeviceTimeoutError, "tester: set load: no answer in time"),
        (TimeoutError("3 s"), DeviceTimeoutError, r"tester: set load: no answer in time \(3 s\)"),
        (ConnectionResetError("gone"), DeviceLostError, r"the connection broke \(gone\)"),
    ],
)
def test_what_python_has_for_a_device_error_becomes_one(raised, kind, message, non_blocking):
    device = FakeTester(before=raising(raised, at="set load 1"), non_blocking=non_blocking)
    with rig_of(device) as rig, pytest.raises(kind, match=message) as caught:
        rig.set("tester", "load", 1.0)
    assert caught.value.__cause__ is raised


@pytest.mark.parametrize(
    "raised",
    [
        DeviceError("bad: OK\x1b[2J", hint="\u202esee"),
        TimeoutError("OK\x1b[2J"),
        ConnectionError("OK\x1b[2J"),
    ],
)
def test_what_a_driver_quotes_of_its_instrument_steers_no_terminal(raised):
    device = FakeTester(before=raising(raised, at="set load 1"))
    with rig_of(device) as rig, pytest.raises(DeviceError, match=r"OK\\x1b\[2J") as caught:
        rig.set("tester", "load", 1.0)
    assert f"{caught.value.message}{caught.value.hint}".isprintable()


def test_an_identity_and_messages_of_a_driver_steer_no_terminal():
    part = Identity("Fakes", "cell", "7\x9b")
    device = FakeTester()
    device.connect = lambda _: Identity("F\x1b[2J", "\u202eX", "1\r", "v\x00", parts={"cell": part})
    rig = rig_of(device)
    identity = rig.connect()["tester"]
    assert identity == Identity(
        r"F\x1b[2J",
        r"\u202eX",
        r"1\r",
        r"v\x00",
        parts={"cell": Identity("Fakes", "cell", r"7\x9b")},
    )
    rig.messages.log_of("tester").warning("read %s", "\x1b[8m")
    assert [message.text for message in rig.messages.taken()] == [r"read \x1b[8m"]


def test_hanging_device_is_abandoned_and_all_are_still_made_safe():
    release = threading.Event()
    hangs = FakeTester(
        non_blocking=False, before=lambda call: release.wait() if call == "block" else None
    )
    other = FakeTester()
    rig = rig_of(hangs, other, answer_s=0.05)
    rig._roles["tester"].caller.grace_s = 0.02
    with pytest.raises(DeviceTimeoutError, match="tester: 'stream' did not return"):
        list(rig.stream("tester", ("torque",), 0.1, NEVER))
    with pytest.raises(DeviceLostError, match="tester: cannot set load"):
        rig.set("tester", "load", 1.0)
    assert [report.safe for report in rig.make_safe()] == [True, True]
    assert hangs.drives_at == other.drives_at == {"load": 0.0, "frequency": 0.0}
    release.set()
    rig.close()


def test_make_safe_goes_on_past_every_failure_and_reports_it():
    broken = FakeTester(before=raising(ZeroDivisionError("bug"), at="make_safe"))
    tester = FakeTester(before=raising(DeviceLostError("cable"), at="make_safe"))
    fine = FakeTester()
    reports = rig_of(broken, tester, fine).make_safe()
    assert [report.safe for report in reports] == [False, False, True]
    assert reports[0].problems == ("make safe failed: ZeroDivisionError: bug",)
    assert reports[1].problems == ("make safe failed: cable",)
    assert reports[2].read_back == {"load": 0.0, "frequency": 0.0}


def test_read_back_that_is_not_the_safe_value_is_not_safe():
    (report,) = rig_of(FakeTester(read_back_offset=0.5)).make_safe()
    assert report.problems == ("frequency reads back 0.5 Hz, safe is 0 Hz",)


def test_drive_without_read_back_is_not_safe():
    device = FakeTester()
    device.drives = (*DRIVES, DriveInfo("heater", "K", "heater", 0.0, 500.0, safe_value=293.15))
    (report,) = rig_of(device).make_safe()
    assert report.problems == ("heater reads back nothing, safe is 20 °C",)


def test_interrupt_while_making_safe_begins_it_anew():
    impatient = FakeTester(before=NthCall(0, KeyboardInterrupt()))
    other = FakeTester()
    reports = rig_of(impatient, other).make_safe()
    assert [report.safe for report in reports] == [True, True]
    assert impatient.calls == ["make_safe", "make_safe"]


def test_close_closes_all_and_raises_the_first_error():
    broken = FakeTester(before=raising(DeviceLostError("cable"), at="close"))
    other = FakeTester()
    with pytest.raises(DeviceError, match="tester: cable"):
        rig_of(broken, other).close()
    assert other.calls == ["close"]


def test_context_makes_safe_and_closes_also_after_an_error():
    device = FakeTester()
    with pytest.raises(ValueError, match="ours"), rig_of(device):
        raise ValueError("ours")
    assert device.calls == ["connect", "make_safe", "close"]


def test_what_a_device_can_do_is_asked_anew_once_it_is_connected():
    tester = FakeTester()
    rig = rig_of(tester)
    with pytest.raises(DeviceRejectedError, match="there is no drive 'speed'"):
        rig.allowed("tester", "speed")
    tester.drives = (DriveInfo("speed", "rad/s", "speed", 0.0, 9.0),)
    rig.connect()
    assert rig.allowed("tester", "speed").maximum == 9.0


def test_a_drive_is_looked_up_anew_once_its_device_is_connected():
    tester = FakeTester()
    rig = rig_of(tester)
    rig.connect()
    assert rig.set("tester", "load", 900.0) == 900.0
    tester.drives = (DriveInfo("load", "N", "load", 0.0, 500.0),)
    rig.connect()
    with pytest.raises(DeviceRejectedError, match=r"load: 900 N is out of range .*0 to 500 N"):
        rig.set("tester", "load", 900.0)


@pytest.mark.parametrize("number", [np.float32(1000), np.int64(1000), 1000, Decimal(1000)])
def test_numbers_of_other_kinds_become_floats(number):
    device = FakeTester()
    device.read_back = lambda _: number
    device.read = lambda channels: dict.fromkeys(channels, number)
    device.make_safe = lambda: {"load": number}
    rig = rig_of(device)
    values = [
        rig.set("tester", "load", 1000.0),
        rig.read("tester", ["load"])["tester.load"],
        rig.make_safe()[0].read_back["load"],
    ]
    assert [(type(value), value) for value in values] == [(float, 1000.0)] * 3


@pytest.mark.parametrize(
    "answer",
    [None, "1000", 1000 + 0j, np.complex128(1000), np.complex64(1000), 10**400, np.arange(2.0), {}],
)
def test_what_is_no_number_is_the_drivers_fault_and_names_the_role(answer):
    device = FakeTester()
    device.read_back = lambda _: answer
    device.read = lambda channels: dict.fromkeys(channels, answer)
    device.make_safe = lambda: {"load": answer, "frequency": 0.0}
    rig = rig_of(device)
    for call in (
        lambda: rig.set("tester", "load", 1000.0),
        lambda: rig.standing("tester", "load"),
        lambda: rig.read("tester", ["load"]),
    ):
        with pytest.raises(DeviceRejectedError, match=r"^tester: the driver gave "):
            call()
    (report,) = rig.make_safe()
    assert not report.safe
    assert "the driver gave" in report.problems[0]


@pytest.mark.parametrize("answer", [None, [1.0], 5])
def test_a_reading_that_is_no_mapping_is_the_drivers_fault(answer):
    device = FakeTester()
    device.read = lambda _: answer
    with pytest.raises(DeviceRejectedError, match=r"^tester: the driver gave "):
        rig_of(device).read("tester", ["load"])


@pytest.mark.parametrize("position", [float("nan"), float("inf")])
def test_where_a_drive_stands_must_be_known_to_say_what_leads_away_from_safe(position):
    device = FakeTester()
    device.read_back = lambda _: position
    with pytest.raises(DeviceRejectedError, match="position is unknown"):
        rig_of(device).leads_away("tester", "load", 3000.0)


def test_the_safe_value_leads_not_away_also_if_the_drive_cannot_be_read_back():
    device = FakeTester(before=raising(DeviceLostError("no answer"), at="read_back load"))
    assert not rig_of(device).leads_away("tester", "load", 0.0)
    with pytest.raises(DeviceLostError, match="no answer"):
        rig_of(device).leads_away("tester", "load", 1.0)


@pytest.mark.parametrize(
    ("kelvin", "away"), [(300.0, False), (270.0, True), (285.0, False), (320.0, True)]
)
def test_what_leads_away_from_safe_is_told_by_the_distance_to_the_safe_value(kelvin, away):
    device = FakeTester()
    heater = DriveInfo("heater", "K", "heater", 0.0, 500.0, safe_value=293.15)
    device.drives = (*DRIVES, heater)
    rig = rig_of(device)
    rig.connect()
    rig.set("tester", "heater", 280.0)
    assert rig.leads_away("tester", "heater", kelvin) is away


@pytest.mark.parametrize("raised", [KeyboardInterrupt(), ZeroDivisionError("a bug")])
def test_what_a_driver_raises_while_its_values_are_looked_at_stays_what_it_is(raised):
    class Values(dict):
        def get(self, *_):
            raise raised

    tester = FakeTester()
    rig = rig_of(tester)
    rig.connect()
    tester.read = lambda _: Values(load=1.0)
    with pytest.raises(type(raised)):
        rig.read("tester", ["load"])


def test_a_stream_may_take_its_duration_beyond_the_patience():
    rig = Rig({"tester": FakeTester(non_blocking=False)}, SimulatedClock(), Patience(answer_s=2.0))
    rig.connect()
    blocks = list(rig.stream("tester", ["torque"], 4.0, NEVER))
    rig.close()
    assert sum(block.samples for block in blocks) == 4000


def test_a_device_may_take_its_time_to_connect():
    slow = FakeTester(non_blocking=False, before=lambda call: time.sleep(0.3 * (call == "connect")))
    rig = Rig({"tester": slow}, SimulatedClock(), Patience(connect_s=100.0))
    rig.connect()
    rig.close()


def test_that_a_rig_is_not_safe_stands_once_beside_an_error():
    error, report = ValueError("first"), SafetyReport("tester", problems=("load stays",))
    for _ in range(2):
        note_unsafe(error, [report])
    assert error.__notes__ == ["the rig is not safe: tester: load stays"]


def test_what_a_device_found_of_its_stream_is_named_by_its_role():
    class Knowing(FakeTester):
        def stream_conditions(self):
            return {"angle_alignment": (np.float32(0.25), "rad")}

    conditions = rig_of(Knowing()).stream_conditions("tester")
    assert conditions == ({"tester.angle_alignment": 0.25}, {"tester.angle_alignment": "rad"})
    assert rig_of(FakeTester()).stream_conditions("tester") == ({}, {})


@pytest.mark.parametrize(
    "conditions",
    [{"a": ("b", "s")}, {"a": (np.nan, "s")}, {"a": (np.inf, "s")}, {"a": 0.2}, {"a": "b"}, 5],
)
def test_wrong_stream_conditions_are_refused_and_name_the_role(conditions):
    class Wrong(FakeTester):
        def stream_conditions(self):
            return conditions

    with pytest.raises(DeviceRejectedError, match=r"^tester: the driver gave .* of its stream "):
        rig_of(Wrong()).stream_conditions("tester")


def test_drives_that_were_made_safe_stand_where_they_are_read_back():
    rig = rig_of(FakeTester())
    rig.connect()
    rig.set("tester", "load", 500.0)
    assert rig.standing("tester", "load") == 500.0
    rig.make_safe()
    assert rig.standing("tester", "load") == 0.0
    assert list(rig.deviating_drives()) == []


def test_what_was_paused_counts_its_cycles_again_once_it_is_resumed():
    class Pauses(FakeTester):
        def pause(self):
            self._record_call("pause")

        def resume(self):
            self._record_call("resume")

    clock = SimulatedClock()
    rig = Rig({"tester": Pauses()}, clock)
    rig.connect()
    rig.set("tester", "frequency", 10.0)
    assert rig.pause() == []
    clock.sleep(60.0)
    rig.resume()
    before = rig.cycles.done()["tester"]
    clock.sleep(1.0)
    assert rig.cycles.done()["tester"] - before == pytest.approx(10.0)


def test_a_device_that_counts_its_streams_is_told_of_the_earlier_ones():
    class Counts(FakeTester):
        def continue_after(self, streams):
            self.earlier = streams

    counts, plain = Counts(), FakeTester()
    rig = rig_of(counts, plain)
    rig.continue_after({"tester": [{"load": 40.0}], "oven": [{"load": 50.0}]})
    assert counts.earlier == [{"load": 40.0}]
    assert plain.calls == []


class Observes(FakeTester):
    """A device with readings that are no numbers."""

    readings = (
        ReadingInfo("firmware", "text", "Firmware"),
        ReadingInfo("door", "boolean", "Door"),
        ReadingInfo("spectrum", "array", "Spectrum", "V"),
    )
    answers: object = None

    def observe(self, names):  # noqa: ARG002
        return self.answers


def observed(readings):
    device = Observes()
    device.answers = readings
    return rig_of(device).observe("tester", list(readings))


def test_readings_that_are_no_numbers_are_of_their_kind():
    readings = {"firmware": "FW2.1", "door": True, "spectrum": [1, Decimal("2.5")]}
    assert observed(readings) == {
        "tester.firmware": "FW2.1",
        "tester.door": True,
        "tester.spectrum": (1.0, 2.5),
    }
    assert observed({"spectrum": (1.0,)}) == {"tester.spectrum": (1.0,)}


@pytest.mark.parametrize(
    ("name", "value", "needed"),
    [
        ("firmware", 2.1, "a str"),
        ("firmware", ("1", "2"), "a str"),
        ("firmware", None, "a str"),
        ("door", 1, "a bool"),
        ("door", [1.0], "a bool"),
        ("spectrum", "1,2", "numbers"),
        ("spectrum", 1.0, "numbers"),
        ("spectrum", [1.0, float("nan")], "numbers"),
        ("spectrum", [1.0, "two"], "number"),
    ],
)
def test_a_reading_of_another_kind_is_the_drivers_fault(name, value, needed):
    with pytest.raises(DeviceRejectedError, match="tester") as error:
        observed({name: value})
    assert needed in str(error.value)
