"""Steps of every kind on a simulated tester."""

from __future__ import annotations

import threading

from helpers_devices import Listener
from rigrunner.api.events import Outcome, StepEnded, StepStarted
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_station
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import rig_of

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


def test_steps_run_in_order_and_events_name_their_kinds(tmp_path):
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
    assert [event.action for event in listener.of(StepStarted)] == kinds
    assert [(event.action, event.ok) for event in listener.of(StepEnded)] == [
        (k, True) for k in kinds
    ]
    loads = [
        dict(event.setpoints)["tester.load"]
        for event in listener.of(StepEnded)
        if event.measurement
    ]
    assert loads == [10.0, 10.0, 20.0, 20.0]
