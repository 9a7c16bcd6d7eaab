"""Runs whose steps a person gives one by one: monitored, recorded and made safe like others."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest

from helpers_devices import FakeTester, Listener, record
from rigrunner.api.errors import DeviceLostError, DeviceRejectedError
from rigrunner.api.events import Intervention, MadeSafe, Outcome, RunEnded, StepEnded, StepStarted
from rigrunner.api.member import Member
from rigrunner.api.units import unit
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import run_by_hand
from rigrunner.engine.run import Run
from rigrunner.plan.actions import Interlock, Phase, PlannedStep, Terms
from rigrunner.rig import Rig
from rigrunner.steps.set_drives import SetDrive
from unit.engine.helpers_pausing import Person


def step(action, **terms):
    return PlannedStep("by_hand", Phase.MAIN, action, "", 0.0, Terms(**terms))


SET = step(SetDrive("tester", "frequency", 10.0, "Hz"))
RECORD = step(record("001", seconds=0.5, frequency=10.0))


def by_hand(steps, device=None, *, stop=None, interlocks=(), listener=None):
    listener, device = listener or Listener(), device or FakeTester()
    clock = SimulatedClock()
    rig = Rig({"tester": device}, clock)
    rig.connect()
    summary = run_by_hand(
        steps,
        rig,
        Bus(critical=[listener]),
        clock,
        stop or threading.Event(),
        "R1",
        interlocks=interlocks,
        pauses=Person([]),
    )
    return summary, listener, device


def test_steps_run_in_order_and_rig_ends_safe():
    positions = []

    def steps(session):
        yield SET
        positions.append(session.rig.standing("tester", "frequency"))
        yield RECORD

    summary, listener, device = by_hand(steps)
    assert (summary.outcome, summary.safe, positions) == (Outcome.COMPLETED, True, [10.0])
    assert [(event.index, event.ok) for event in listener.of(StepEnded)] == [(0, True), (1, True)]
    assert device.drives_at["frequency"] == 0.0
    assert listener.of(MadeSafe)
    assert listener.of(RunEnded)[0].outcome is Outcome.COMPLETED


def test_failed_step_ends_run_unless_it_continues():
    class Stubborn(FakeTester):
        def set(self, drive, value):
            raise DeviceRejectedError(f"{drive} is stuck at {value}")

    summary, listener, _ = by_hand(lambda _: iter([SET, RECORD]), Stubborn())
    assert (summary.outcome, len(listener.of(StepStarted))) == (Outcome.ERROR, 1)
    continues = replace(SET, terms=Terms(continues=True))
    summary, listener, _ = by_hand(lambda _: iter([continues, RECORD]), Stubborn())
    assert (summary.outcome, len(listener.of(StepStarted))) == (Outcome.COMPLETED, 2)
    assert "stuck" in summary.passed_over[0]


def test_manual_session_is_never_resumable():
    """There is no plan to resume, even if the session ended with a lost device."""

    def lose(call):
        if call.startswith("set"):
            raise DeviceLostError("cable")

    summary, listener, _ = by_hand(lambda _: iter([SET]), FakeTester(before=lose))
    assert isinstance(summary.error, DeviceLostError)
    assert not summary.resumable
    assert [event.resumable for event in listener.of(RunEnded)] == [False]


def test_stop_request_aborts_between_steps():
    stop = threading.Event()

    def steps(_):
        yield SET
        stop.set()
        yield RECORD

    summary, listener, device = by_hand(steps, stop=stop)
    assert summary.outcome is Outcome.ABORTED
    assert [event.action for event in listener.of(Intervention)] == ["abort"]
    assert len(listener.of(StepStarted)) == 1
    assert device.drives_at["frequency"] == 0.0


@pytest.mark.parametrize("does", ["pause", "abort", "make_safe"])
def test_every_kind_of_interlock_aborts(does):
    lock = Interlock(
        name="load", member=Member("tester", "load"), condition="above 5 N", shown=unit("N"),
        maximum=5.0, does=does,
    )  # fmt: skip

    def steps(session):
        yield SET
        yield step(SetDrive("tester", "load", 100.0, "N"))
        yield RECORD
        session.check(read_all=True)

    summary, _, device = by_hand(steps, interlocks=[lock])
    assert summary.outcome is Outcome.ABORTED
    assert "tester.load is 100" in summary.reason
    assert set(device.drives_at.values()) == {0.0}


def test_error_in_step_generator_makes_rig_safe():
    def steps(_):
        yield SET
        raise ZeroDivisionError("oops")

    summary, _, device = by_hand(steps)
    assert (summary.outcome, type(summary.error)) == (Outcome.ERROR, ZeroDivisionError)
    assert device.drives_at["frequency"] == 0.0


def test_interrupt_between_steps_makes_rig_safe(monkeypatch):
    def interrupted(_, work):
        work()
        raise KeyboardInterrupt

    monkeypatch.setattr(Run, "attempt", interrupted)
    summary, _, device = by_hand(lambda _: iter([SET]))
    assert (summary.outcome, type(summary.error)) == (Outcome.ABORTED, KeyboardInterrupt)
    assert device.drives_at["frequency"] == 0.0
