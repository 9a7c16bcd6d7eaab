"""What holds of every module of the room: one kind each, and its events carry its keyword."""

from __future__ import annotations

import threading
from dataclasses import is_dataclass
from importlib import import_module
from pkgutil import iter_modules

import pytest

from helpers_devices import Listener
from rigrunner import steps
from rigrunner.api.events import Outcome, StepEnded, StepStarted
from rigrunner.api.steps import Action
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_station
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import rig_of
from rigrunner.steps.hooks import rigrunner_steps

NAMES = sorted(each.name for each in iter_modules(steps.__path__) if each.name != "hooks")
MODULES = {name: import_module(f"{steps.__name__}.{name}") for name in NAMES}
PROCEDURE = """\
rigrunner: procedure/2
id: KIND
revision: "1"
title: Steps of every kind that leads, reads or waits
measurand: {symbol: T, name: torque of a swing, unit: N·m}
uses: {tester: swing_tester}
setup:
  - zero: {channel: tester.torque, within: 0.5 N·m, duration: 0.1 s}
main:
  - note: {text: begun}
  - confirm: {text: Is it so?, unattended: yes}
  - set: {tester.load: 100 N}
  - ramp: {drive: tester.load, to: 200 N, time: 1 s}
  - wait: {time: 0.5 s}
  - scan: {set: tester.load, over: [0 N, 50 N], channels: [tester.load]}
  - sweep:
      set: tester.load
      over: [10 N, 20 N]
      steps:
        - repeat: {times: 2, steps: [{measure: {channels: [tester.load], name: loads}}]}
  - set: {tester.frequency: 2 Hz}
  - settle: {cycles: 1}
  - record: {channels: [tester.torque], cycles: 1}
teardown:
  - set: {tester.frequency: 0 Hz}
  - set: {tester.load: 0 N}
"""


@pytest.mark.parametrize("name", NAMES)
def test_a_module_has_one_kind_and_its_actions_carry_its_keyword(name):
    module = MODULES[name]
    own = [
        each for each in vars(module).values() if getattr(each, "__module__", "") == module.__name__
    ]
    actions = [each for each in own if isinstance(each, type) and issubclass(each, Action)]
    assert {each.kind for each in actions} <= {module.STEP.name}
    assert all(is_dataclass(each) and each.__dataclass_params__.frozen for each in actions)
    assert module.STEP.settings in own
    assert f"`{module.STEP.name}`" in module.__doc__.splitlines()[0]


def test_the_hook_gives_the_kind_of_every_module_and_no_other():
    assert sorted(each.name for each in rigrunner_steps()) == sorted(
        module.STEP.name for module in MODULES.values()
    )


def test_kinds_are_done_in_their_order_and_their_events_name_them(tmp_path):
    procedure = tmp_path / "procedure.yaml"
    procedure.write_text(PROCEDURE, encoding="utf-8")
    clock, listener = SimulatedClock(), Listener()
    planned = plan_run(procedure, find_station("simulated"), load_registry(), clock)
    with rig_of(planned) as rig:
        unattended = UnattendedAnswers(), threading.Event(), "run"
        summary = run_plan(planned.plan, rig, Bus([listener]), planned.clock, *unattended)
    assert summary.outcome is Outcome.COMPLETED, summary.reason
    read = ["set", "measure", "measure"]
    kinds = [
        "zero", "note", "confirm", "set", "ramp", "wait", "scan", *read, *read, "set", "settle",
        "record", "set", "set",
    ]  # fmt: skip
    assert [one.action for one in listener.of(StepStarted)] == kinds
    assert [(one.action, one.ok) for one in listener.of(StepEnded)] == [(k, True) for k in kinds]
    loads = [
        dict(one.setpoints)["tester.load"] for one in listener.of(StepEnded) if one.measurement
    ]
    assert loads == [10.0, 10.0, 20.0, 20.0]
