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


def test_fake_tester_has_all_abilities():
    for ability in (Device, Readable, Settable, Streaming, KnowsTruth):
        assert isinstance(FakeTester(), ability)


def test_connect_returns_identities():
    assert rig_of(FakeTester()).connect()["tester"].maker == "Fakes"


@pytest.mark.parametrize(
    "identity", [None, "ACME", Identity(None, "x", "1"), Identity("ACME", "x", 5)]
)
def test_invalid_identity_is_refused(identity):
    tester = FakeTester()
    tester.connect = lambda _: identity
    with pytest.raises(DeviceRejectedError, match="tester: connect gave"):
        Rig({"tester": tester}, SimulatedClock()).connect()
    assert tester.calls == ["make_safe", "close"]


@pytest.mark.parametrize("non_blocking", [True, False])
@pytest.mark.parametrize("raised", [SystemExit(0), CancelledError()])
def test_driver_that_ends_program_raises_runtime_error(raised, non_blocking):
    """Otherwise the command would end with exit code 0."""

    def fail(call):
        if call.startswith("read "):
            raise raised

    tester = FakeTester(non_blocking=non_blocking, before=fail)
    rig = Rig({"tester": tester}, SimulatedClock())
    with rig, pytest.raises(RuntimeError, match=f"'read' raised {type(raised).__name__}"):
        rig.read("tester", ["torque"])


def test_unexpected_driver_error_has_note_with_role():
    tester = FakeTester(before=NthCall(1, ValueError("oops")))
    rig = Rig({"tester": tester}, SimulatedClock())
    with rig, pytest.raises(ValueError, match="oops") as caught:
        rig.read("tester", ["torque"])
    assert caught.value.__notes__ == ["in the device of the role 'tester': read"]


def test_failed_connect_names_role_and_leaves_all_safe_and_closed():
    first = FakeTester()
    unplugged = FakeTester(before=raising(DeviceNotFoundError("nothing at COM3"), at="connect"))
    third = FakeTester()
    with pytest.raises(DeviceNotFoundError, match="oven: nothing at COM3"):
        rig_of(first, unplugged, third).connect()
    assert first.calls == ["connect", "make_safe", "close"]
    assert unplugged.calls == ["connect", "make_safe", "close"]
    assert "connect" not in third.calls


def test_failed_connect_notes_devices_that_are_not_safe():
    first = FakeTester(read_back_offset=50.0)
    unplugged = FakeTester(
        before=raising(DeviceNotFoundError("nothing at COM3"), at="connect"), read_back_offset=50.0
    )
    with pytest.raises(DeviceNotFoundError) as caught:
        rig_of(first, unplugged).connect()
    (note,) = caught.value.__notes__
    assert note.startswith("the rig is not safe: tester: load reads back 50 N, safe is 0 N; ")
    assert "oven" not in note, "one that does not answer is the error itself"


def test_error_while_closing_is_a_note_of_first_error():
    unplugged = FakeTester(before=raising(DeviceNotFoundError("nothing at COM3"), at="connect"))
    broken = FakeTester(before=raising(DeviceLostError("cable"), at="close"))
    with pytest.raises(DeviceNotFoundError) as caught:
        rig_of(unplugged, broken).connect()
    assert caught.value.__notes__ == ["closing the rig failed too: oven: cable"]


def test_set_returns_read_back():
    device = FakeTester(read_back_offset=-3.0)
    assert rig_of(device).set("tester", "load", 1000.0) == 997.0
    assert device.calls == ["set load 1000", "read_back load"]


@pytest.mark.parametrize("value", [-1.0, 3000.1, float("nan")])
def test_set_point_out_of_range_never_reaches_device(value):
    device = FakeTester()
    with pytest.raises(
        DeviceRejectedError, match=r"tester: load: .* N is out of range .*0 to 3000"
    ):
        rig_of(device).set("tester", "load", value)
    assert device.calls == []


def test_read_back_deviating_by_more_than_one_percent_of_range_is_refused():
    device = FakeTester(read_back_offset=30.1)
    with pytest.raises(DeviceRejectedError, match=r"1000 N but reads back 1030.1 N .*within 30 N"):
        rig_of(device).set("tester", "load", 1000.0)


def test_read_back_of_nan_is_refused():
    rig = rig_of(FakeTester(read_back_offset=float("nan")))
    rig.connect()
    with pytest.raises(DeviceRejectedError, match="was set to 100 N but reads back nan N"):
        rig.set("tester", "load", 100.0)


def test_declared_tolerance_applies():
    device = FakeTester(read_back_offset=0.6)
    device.drives = (DriveInfo("load", "N", "load", 0.0, 3000.0, tolerance=0.5),)
    with pytest.raises(DeviceRejectedError, match=r"within 0\.5 N"):
        rig_of(device).set("tester", "load", 1000.0)


def test_unknown_drive_and_missing_ability_are_refused():
    class Mute(FakeTester):
        read_back = None

    with pytest.raises(DeviceRejectedError, match=r"no drive 'speed'.*there are: load, frequency"):
        rig_of(FakeTester()).set("tester", "speed", 1.0)
    with pytest.raises(DeviceRejectedError, match="tester: the device is not settable"):
        rig_of(Mute()).set("tester", "load", 1.0)


def test_conditions_are_all_readable_channels_not_streamed():
    tester, oven = FakeTester(), FakeTester()
    values, units = rig_of(tester, oven).conditions("tester", ("angle", "torque"))
    assert set(values) == {"tester.load", "oven.angle", "oven.torque", "oven.load"}
    assert units["oven.torque"] == "N·m"
    assert tester.calls == ["read load"]


def test_condition_of_nan_is_refused():
    with pytest.raises(DeviceRejectedError, match="tester: no value was read of load"):
        rig_of(FakeTester(read_back_offset=float("nan"))).conditions("tester", ("angle", "torque"))


@pytest.mark.parametrize("non_blocking", [True, False])
def test_stream_yields_blocks(non_blocking):
    device = FakeTester(non_blocking=non_blocking)
    rig = rig_of(device)
    blocks = list(rig.stream("tester", ("torque",), 0.25, NEVER))
    assert [block.samples for block in blocks] == [100, 100, 50]
    assert (blocks[2].channels["torque"] == samples_of("torque", 200, 50)).all()
    ours = threading.current_thread().name
    assert device.threads == {ours if non_blocking else "device tester"}
    rig.close()


@pytest.mark.parametrize("non_blocking", [True, False])
def test_abandoned_stream_ends_on_device_before_next_call(non_blocking):
    streams = []  # else the garbage collector might end the stream

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
        # a USB adapter was unplugged, or a network cable
        (OSError(5, "broken"), DeviceLostError, r"the connection broke \(\[Errno 5\] broken\)"),
    ],
)
def test_built_in_errors_become_device_errors(raised, kind, message, non_blocking):
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
def test_control_characters_in_driver_errors_are_escaped(raised):
    device = FakeTester(before=raising(raised, at="set load 1"))
    with rig_of(device) as rig, pytest.raises(DeviceError, match=r"OK\\x1b\[2J") as caught:
        rig.set("tester", "load", 1.0)
    assert f"{caught.value.message}{caught.value.hint}".isprintable()


def test_control_characters_in_identity_and_messages_are_escaped():
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
    rig = rig_of(hangs, other, answer_s=1.0)
    rig._roles["tester"].caller.grace_s = 0.02
    with pytest.raises(DeviceTimeoutError, match="tester: 'stream' did not return"):
        list(rig.stream("tester", ("torque",), 0.1, NEVER))
    with pytest.raises(DeviceLostError, match="tester: cannot set load"):
        rig.set("tester", "load", 1.0)
    assert [report.safe for report in rig.make_safe()] == [True, True]
    assert hangs.drives_at == other.drives_at == {"load": 0.0, "frequency": 0.0}
    release.set()
    rig.close()


def test_make_safe_continues_after_failures_and_reports_them():
    broken = FakeTester(before=raising(ZeroDivisionError("bug"), at="make_safe"))
    tester = FakeTester(before=raising(DeviceLostError("cable"), at="make_safe"))
    fine = FakeTester()
    reports = rig_of(broken, tester, fine).make_safe()
    assert [report.safe for report in reports] == [False, False, True]
    assert reports[0].problems == ("make safe failed: ZeroDivisionError: bug",)
    assert reports[1].problems == ("make safe failed: cable",)
    assert reports[2].read_back == {"load": 0.0, "frequency": 0.0}


def test_unsafe_read_back_is_reported():
    (report,) = rig_of(FakeTester(read_back_offset=0.5)).make_safe()
    assert report.problems == ("frequency reads back 0.5 Hz, safe is 0 Hz",)


def test_drive_without_read_back_is_reported_as_not_safe():
    device = FakeTester()
    device.drives = (*DRIVES, DriveInfo("heater", "K", "heater", 0.0, 500.0, safe_value=293.15))
    (report,) = rig_of(device).make_safe()
    assert report.problems == ("heater reads back nothing, safe is 20 °C",)


def test_interrupt_restarts_making_safe():
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


def test_context_makes_safe_and_closes_after_an_error():
    device = FakeTester()
    with pytest.raises(ValueError, match="ours"), rig_of(device):
        raise ValueError("ours")
    assert device.calls == ["connect", "make_safe", "close"]


def test_drives_are_updated_on_connect():
    tester = FakeTester()
    rig = rig_of(tester)
    with pytest.raises(DeviceRejectedError, match="there is no drive 'speed'"):
        rig.allowed("tester", "speed")
    tester.drives = (DriveInfo("speed", "rad/s", "speed", 0.0, 9.0),)
    rig.connect()
    assert rig.allowed("tester", "speed").maximum == 9.0


def test_range_of_drive_is_updated_on_reconnect():
    tester = FakeTester()
    rig = rig_of(tester)
    rig.connect()
    assert rig.set("tester", "load", 900.0) == 900.0
    tester.drives = (DriveInfo("load", "N", "load", 0.0, 500.0),)
    rig.connect()
    with pytest.raises(DeviceRejectedError, match=r"load: 900 N is out of range .*0 to 500 N"):
        rig.set("tester", "load", 900.0)


@pytest.mark.parametrize("number", [np.float32(1000), np.int64(1000), 1000, Decimal(1000)])
def test_other_number_types_become_floats(number):
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
def test_values_that_are_not_numbers_are_refused_and_name_the_role(answer):
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
def test_readings_that_are_not_a_mapping_are_refused(answer):
    device = FakeTester()
    device.read = lambda _: answer
    with pytest.raises(DeviceRejectedError, match=r"^tester: the driver gave "):
        rig_of(device).read("tester", ["load"])


@pytest.mark.parametrize("position", [float("nan"), float("inf")])
def test_leads_away_needs_a_finite_position(position):
    device = FakeTester()
    device.read_back = lambda _: position
    with pytest.raises(DeviceRejectedError, match="position is unknown"):
        rig_of(device).leads_away("tester", "load", 3000.0)


def test_safe_value_never_leads_away_even_if_drive_is_unreadable():
    device = FakeTester(before=raising(DeviceLostError("no answer"), at="read_back load"))
    assert not rig_of(device).leads_away("tester", "load", 0.0)
    with pytest.raises(DeviceLostError, match="no answer"):
        rig_of(device).leads_away("tester", "load", 1.0)


@pytest.mark.parametrize(
    ("kelvin", "away"), [(300.0, False), (270.0, True), (285.0, False), (320.0, True)]
)
def test_leads_away_compares_distances_to_safe_value(kelvin, away):
    device = FakeTester()
    heater = DriveInfo("heater", "K", "heater", 0.0, 500.0, safe_value=293.15)
    device.drives = (*DRIVES, heater)
    rig = rig_of(device)
    rig.connect()
    rig.set("tester", "heater", 280.0)
    assert rig.leads_away("tester", "heater", kelvin) is away


@pytest.mark.parametrize("raised", [KeyboardInterrupt(), ZeroDivisionError("a bug")])
def test_error_raised_by_mapping_of_driver_is_not_converted(raised):
    class Values(dict):
        def get(self, *_):
            raise raised

    tester = FakeTester()
    rig = rig_of(tester)
    rig.connect()
    tester.read = lambda _: Values(load=1.0)
    with pytest.raises(type(raised)):
        rig.read("tester", ["load"])


def test_stream_may_last_longer_than_answer_timeout():
    rig = Rig({"tester": FakeTester(non_blocking=False)}, SimulatedClock(), Patience(answer_s=2.0))
    rig.connect()
    blocks = list(rig.stream("tester", ["torque"], 4.0, NEVER))
    rig.close()
    assert sum(block.samples for block in blocks) == 4000


def test_slow_connect_is_allowed_by_patience():
    slow = FakeTester(non_blocking=False, before=lambda call: time.sleep(0.3 * (call == "connect")))
    rig = Rig({"tester": slow}, SimulatedClock(), Patience(connect_s=100.0))
    rig.connect()
    rig.close()


def test_connect_that_never_returns_is_given_up():
    release = threading.Event()
    hanging = FakeTester(non_blocking=False, before=lambda _: release.wait(5.0))
    failed = rig_of(hanging, connect_s=0.02).connect_each()
    release.set()
    assert failed == {"tester": "tester: 'connect' did not return within 0.04 s"}


def test_unsafe_rig_is_noted_once():
    error, report = ValueError("first"), SafetyReport("tester", problems=("load stays",))
    for _ in range(2):
        note_unsafe(error, [report])
    assert error.__notes__ == ["the rig is not safe: tester: load stays"]


def test_stream_conditions_are_named_by_role():
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


def test_positions_after_make_safe_are_the_read_backs():
    rig = rig_of(FakeTester())
    rig.connect()
    rig.set("tester", "load", 500.0)
    assert rig.standing("tester", "load") == 500.0
    rig.make_safe()
    assert rig.standing("tester", "load") == 0.0
    assert list(rig.deviating_drives()) == []


def test_cycles_count_again_after_resume():
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


def test_device_that_counts_streams_receives_earlier_ones():
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


def test_readings_of_each_kind_are_returned():
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
def test_reading_of_wrong_kind_is_refused(name, value, needed):
    with pytest.raises(DeviceRejectedError, match="tester") as error:
        observed({name: value})
    assert needed in str(error.value)
