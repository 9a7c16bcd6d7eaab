"""Each check of step kinds fails a kind that is broken in that way."""

# ruff: noqa: ARG002  (the signature of an action)

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import pytest

from rigrunner.api.errors import AbortedError, InvalidFileError
from rigrunner.api.hooks import StepRecord
from rigrunner.api.settings import PositiveDuration
from rigrunner.api.steps import NOTHING, Action, StepSettings
from rigrunner.plan import make_plan
from rigrunner.procedure import kinds_of, parse_procedure
from rigrunner.registry import Registry, load_registry
from rigrunner.registry.lookup import Plugin, Provider
from rigrunner.station import parse_station
from rigrunner_testing import conform, subject
from rigrunner_testing.steps import (
    STATION,
    is_planned,
    is_resumed_or_refuses,
    leaves_the_rig_safe,
    stops_when_asked,
    takes_its_time,
)

LAB = Provider("lab", "1")


class DwellStep(StepSettings):
    """Time passes."""

    time: PositiveDuration = 10.0
    """How long."""


@dataclass(frozen=True)
class Dwell(Action):
    kind = "dwell"
    duration_s: float

    def do(self, step, doing):
        doing.wait(self.duration_s)
        return NOTHING


@dataclass
class NotFrozen(Action):
    """Is not frozen."""

    kind = "dwell"


class SleepsByItself(Dwell):
    """Sleeps past the engine."""

    def do(self, step, doing):
        doing.clock.sleep(self.duration_s)
        return NOTHING


class Slow(Dwell):
    """Takes longer than planned."""

    def do(self, step, doing):
        doing.wait(2 * self.duration_s)
        return NOTHING


class SwallowsTheStop(Dwell):
    """Ends as if completed when the run is stopped."""

    def do(self, step, doing):
        with contextlib.suppress(AbortedError):
            doing.wait(self.duration_s)
        return NOTHING


class BreaksTheDevice(Dwell):
    """Breaks the device, so that it cannot be made safe."""

    def do(self, step, doing):
        device = doing.rig.devices["tester"]
        device.make_safe = device.set = None
        return NOTHING


def registry_with(action, seconds=None):
    def plan(settings, planning):
        step_action = action(settings.time)
        planning.emit(step_action, "Dwell", settings.time if seconds is None else seconds)

    record = StepRecord(name="dwell", help="Time passes.", settings=DwellStep, factory=plan)
    return Registry([*load_registry().plugins, Plugin("step", record, LAB)])


def failure(action, check, seconds=None):
    with pytest.raises(AssertionError) as raised:
        conform(subject("step", "dwell", registry=registry_with(action, seconds)), check)
    return str(raised.value)


@pytest.mark.parametrize(
    "check",
    [is_planned, takes_its_time, stops_when_asked, leaves_the_rig_safe, is_resumed_or_refuses],
    ids=lambda check: check.name,
)
def test_sound_kind_passes(check):
    assert not conform(subject("step", "dwell", registry=registry_with(Dwell)), check)


@pytest.mark.parametrize(
    ("action", "check", "message"),
    [
        (lambda _: NotFrozen(), is_planned, "NotFrozen is not a frozen dataclass"),
        (Slow, takes_its_time, "it took 20 s and was planned for 10 s"),
        (SleepsByItself, stops_when_asked, "after it was asked to"),
        (SwallowsTheStop, is_resumed_or_refuses, "it ended as if it was done"),
        (BreaksTheDevice, leaves_the_rig_safe, "the rig was left"),
    ],
    ids=["not frozen", "slow", "sleeps by itself", "swallows the stop", "unsafe"],
)
def test_broken_kind_fails(action, check, message):
    assert message in failure(action, check)


PROCEDURE = """\
rigrunner: procedure/2
id: LAB-1
revision: "A"
title: With a step of the lab's own
measurand: {symbol: Td, name: torque}
uses: {tester: swing_tester}
main: [{dwell: {time: 3 s}}]
"""


def test_procedure_uses_a_step_kind_of_the_lab():
    kinds = kinds_of(registry_with(Dwell))
    (step,) = parse_procedure(PROCEDURE, "p.yaml", kinds=kinds).model.main
    assert (step.kind, step.settings.time) == ("dwell", 3.0)
    with pytest.raises(InvalidFileError, match="unknown step 'dwell'"):
        parse_procedure(PROCEDURE, "p.yaml")


def test_stored_procedure_of_a_missing_kind_is_read_but_not_planned():
    stored = parse_procedure(PROCEDURE, "p.yaml", stored=True)
    assert stored.model.main[0].kind == "dwell"
    with pytest.raises(InvalidFileError, match="is not installed here"):
        make_plan(stored, parse_station(STATION, "s.yaml"), {})
