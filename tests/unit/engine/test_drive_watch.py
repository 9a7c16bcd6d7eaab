"""Drives during readings: each is read back, and one that deviates ends the run."""

from __future__ import annotations

import threading

import pytest

from helpers_devices import FakeTester, Listener, plan_of, record, run
from rigrunner.api.events import InterlockTripped, Outcome, Samples, StepEnded
from rigrunner.api.member import Member
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.engine.drive_watch import DriveWatch
from rigrunner.engine.interlocks import InterlockError
from rigrunner.rig import Rig
from rigrunner.steps.measure import Measure
from rigrunner.steps.scan import Scan
from rigrunner.steps.set_drives import SetDrive


class Bench(FakeTester):
    """A tester whose load another process sets to zero at one of the calls."""

    def __init__(self, at: str = "", number: int = 1, **more) -> None:
        super().__init__(**more)
        self.at, self.number = at, number

    def _record_call(self, call):
        super()._record_call(call)
        if call == self.at and self.calls.count(call) == self.number:
            self.drives_at["load"] = 0.0


UNITS = {"tester.torque": "N·m"}
MEASURE = Measure("torque", (Member("tester", "torque"),), 0.0, {"tester.load": 1000.0}, UNITS)
LOADED = SetDrive("tester", "load", 1000.0, "N")


@pytest.mark.parametrize(
    ("bench", "action"), [(Bench("read torque"), MEASURE), (Bench("block", 2), record("001"))]
)
def test_drive_deviating_during_reading_ends_run(bench, action):
    listener = Listener()
    summary = run(bench, plan_of((), [LOADED, action], ()), critical=[listener])
    assert summary.outcome is Outcome.ABORTED
    assert summary.safe
    text = "tester.load was set to 1000 N and reads back 0 N (tolerance ±30 N)"
    assert summary.reason == text
    (tripped,) = listener.of(InterlockTripped)
    assert (tripped.source, tripped.text, tripped.does) == ("drive tester.load", text, "make_safe")
    ended = listener.of(StepEnded)[-1]
    assert not ended.ok  # which marks the sample; it is kept
    assert ended.values
    assert bench.calls[-1] == "make_safe"


def test_drive_deviating_between_steps_is_detected_before_reading():
    bench = Bench("set frequency 10")
    steps = [LOADED, SetDrive("tester", "frequency", 10.0, "Hz"), MEASURE]
    summary = run(bench, plan_of((), steps, ()))
    assert summary.outcome is Outcome.ABORTED
    assert "read torque" not in bench.calls


def test_rig_is_made_safe_before_teardown_if_drive_deviates():
    bench = Bench("read torque")
    teardown = [SetDrive("tester", "frequency", 0.0, "Hz")]
    run(bench, plan_of((), [LOADED, MEASURE], teardown))
    assert bench.calls.index("make_safe") < bench.calls.index("set frequency 0")


def test_drive_reading_back_nan_ends_run():
    class Mute(FakeTester):
        def read_back(self, drive):
            late = self.calls.count("read_back load") > 0
            return float("nan") if late else super().read_back(drive)

    summary = run(Mute(), plan_of((), [LOADED, MEASURE], ()))
    assert summary.outcome is Outcome.ABORTED
    assert "reads back nan N" in summary.reason


def test_single_deviating_read_back_is_ignored():
    class Noisy(FakeTester):
        def read_back(self, drive):
            off = self.calls.count("read_back load") == 1
            return super().read_back(drive) + 500.0 * off

    assert run(Noisy(), plan_of((), [LOADED, MEASURE], ())).outcome is Outcome.COMPLETED


def test_unset_drives_are_not_read_back():
    bench = Bench()
    assert run(bench, plan_of((), [MEASURE], ())).outcome is Outcome.COMPLETED
    assert "read_back load" not in bench.calls


def test_drive_of_other_device_is_monitored_during_stream():
    """The press deviates while the tester records; this is detected between two blocks."""
    press = FakeTester()

    def unload(call):
        if call == "block" and tester.calls.count("block") == 2:
            press.drives_at["load"] = 0.0

    tester = FakeTester(before=unload)
    clock = SimulatedClock()
    tester.spoil = lambda blocks: _slowly(blocks, clock)
    steps = [SetDrive("press", "load", 1000.0, "N"), record("001", seconds=1.0)]
    listener = Listener()
    rig = Rig({"tester": tester, "press": press}, clock)
    rig.connect()
    bus = Bus([listener])
    plan = plan_of((), steps, ())
    summary = run_plan(plan, rig, bus, clock, UnattendedAnswers(), threading.Event(), "run")
    assert summary.reason.startswith("press.load was set to 1000 N and reads back 0 N")
    assert len(listener.of(Samples)) < 10


@pytest.mark.parametrize("reads_back", [True, False])
def test_streaming_device_is_read_back_only_if_it_supports_it(reads_back):
    clock = SimulatedClock()
    tester = FakeTester()
    tester.reads_back_while_streaming = reads_back
    tester.spoil = lambda blocks: _slowly(blocks, clock)
    rig = Rig({"tester": tester}, clock)
    rig.connect()
    plan = plan_of((), [LOADED, record("001", seconds=1.0)], ())
    summary = run_plan(plan, rig, Bus([]), clock, UnattendedAnswers(), threading.Event(), "run")
    assert summary.outcome is Outcome.COMPLETED
    first = tester.calls.index("block")
    last = len(tester.calls) - tester.calls[::-1].index("block")
    assert ("read_back load" in tester.calls[first:last]) is reads_back


def _slowly(blocks, clock):
    for block in blocks:
        clock.sleep(0.1)
        yield block


SCAN = Scan(
    name="sweep",
    role="tester",
    drive="frequency",
    values=tuple(float(number) for number in range(1, 11)),
    channels=(Member("tester", "torque"),),
    settle_s=0.0,
    setpoints={"tester.load": 1000.0},
    units={"tester.torque": "N·m", "tester.frequency": "Hz"},
)


@pytest.mark.parametrize("at", ["read torque", "set frequency 5"])
def test_drive_deviating_during_scan_of_another_ends_run(at):
    summary = run(Bench(at), plan_of((), [LOADED, SCAN], ()))
    assert summary.outcome is Outcome.ABORTED
    assert summary.reason.startswith("tester.load was set to 1000 N and reads back 0 N")


def test_slow_scan_ends_at_point_of_deviation():
    clock = SimulatedClock()
    bench = Bench("read torque", before=lambda call: clock.sleep(0.2 * (call == "read torque")))
    assert run(bench, plan_of((), [LOADED, SCAN], ()), clock=clock).outcome is Outcome.ABORTED
    assert bench.calls.count("read torque") == 1


def test_latency_counts_from_last_good_check():
    clock, device, events = SimulatedClock(), FakeTester(), []
    rig = Rig({"tester": device}, clock)
    rig.connect()
    watch = DriveWatch(rig, lambda _kind, **fields: events.append(fields))
    rig.set("tester", "load", 500.0)
    clock.sleep(5.0)
    watch.check()
    clock.sleep(0.25)
    device.drives_at["load"] = 0.0
    with pytest.raises(InterlockError):
        watch.look()
    assert events[0]["latency_s"] == pytest.approx(0.25)
