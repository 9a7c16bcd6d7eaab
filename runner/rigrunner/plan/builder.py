"""Walks a procedure and writes down every single action."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner.api.quantity import LONGEST_S, readable
from rigrunner.plan.actions import Phase
from rigrunner.plan.draft import Draft, Place, Scene
from rigrunner.plan.drives import DriveStates
from rigrunner.plan.motions import plan_ramp, plan_set, plan_set_point, plan_settle, plan_wait
from rigrunner.plan.questions import plan_question
from rigrunner.plan.readings import plan_measure, plan_record, plan_scan, plan_zero
from rigrunner.plan.size import actions_in, recordings_in
from rigrunner.procedure import steps as language

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.plan.bench import Bench
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.yamlfile.problems import Problems

MAX_ACTIONS = 100_000


def build(procedure: LoadedProcedure, bench: Bench, problems: Problems) -> Draft:
    """Return all actions of a procedure; what cannot be done is added to the problems."""
    actions = actions_in(procedure)
    if actions > MAX_ACTIONS:
        message = f"the procedure has {actions:,} actions, more than {MAX_ACTIONS:,}"
        hint = "look at nested sweeps and repetitions"
        problems.add(procedure.document, ("main",), message, hint, key=True)
        problems.stop_if_any()
    draft = Draft(recordings_in(procedure))
    drives = DriveStates(bench, procedure.document, problems)
    walker = _Walker(procedure, Scene(procedure.document, bench, drives, problems, draft))
    for phase in Phase:
        walker.section(phase.value, Place(phase, (phase.value,), phase.value))
    seconds = sum(step.estimated_s for step in draft.steps)
    if seconds > LONGEST_S:
        most = readable(LONGEST_S, "time")
        message = f"the procedure would take {seconds:.3g} s, allowed is at most {most}"
        problems.add(procedure.document, ("main",), message, "look at its repetitions", key=True)
    return draft


@dataclass(frozen=True, eq=False)
class _Walker:
    """Goes through the steps of one procedure file."""

    procedure: LoadedProcedure
    scene: Scene

    def section(self, name: str, place: Place) -> None:
        """Write down the actions of 'setup', 'main' or 'teardown'."""
        self._steps(getattr(self.procedure.model, name), place)

    def _steps(self, steps: Sequence[language.Step], place: Place) -> None:
        for index, step in enumerate(steps):
            self._step(step, place.step(index))

    def _step(self, step: language.Step, place: Place) -> None:
        match step:
            case language.SweepStep(sweep=sweep):
                self._sweep(sweep, place.inside("sweep"))
            case language.RepeatStep(repeat=repeat):
                at = place.inside("repeat")
                for index in range(repeat.times):
                    self._steps(repeat.steps, at.time(index).inside("steps"))
            case language.CallStep():
                self._call(self.procedure.called[place.path], place.inside("call"))
            case _:
                self._single(step, place)

    def _sweep(self, sweep: language.Sweep, place: Place) -> None:
        for index, quantity in enumerate(sweep.over):
            plan_set_point(sweep.set, quantity, index, place, self.scene)
            self._steps(sweep.steps, place.time(index).inside("steps"))

    def _call(self, called: LoadedProcedure, place: Place) -> None:
        """Write down another procedure's steps; in a teardown, all of them are teardown."""
        ending = place.phase is Phase.TEARDOWN
        calls = place.calls if ending else (*place.calls, place.label)
        bench = self.scene.bench.of(called)
        drives = self.scene.drives.of(bench, called.document)
        scene = replace(self.scene, document=called.document, bench=bench, drives=drives)
        for section in Phase:
            phase = section if section is Phase.TEARDOWN else place.phase
            label = f"{place.label}.{section}"
            _Walker(called, scene).section(
                section.value, Place(phase, (section.value,), label, calls, place.points)
            )

    def _single(self, step: language.Step, place: Place) -> None:
        scene = self.scene
        match step:
            case language.ConfirmStep() | language.AskStep() | language.NoteStep():
                plan_question(step, place, self.procedure.folder, scene)
            case language.WaitStep(wait=wait):
                plan_wait(wait, place.inside("wait"), scene)
            case language.ZeroStep(zero=zero):
                plan_zero(zero, place.inside("zero"), scene)
            case language.SetStep(set=targets):
                plan_set(targets, place.inside("set"), scene)
            case language.RampStep(ramp=ramp):
                plan_ramp(ramp, place.inside("ramp"), scene)
            case language.SettleStep(settle=settle):
                plan_settle(settle, place.inside("settle"), scene)
            case language.RecordStep(record=record):
                plan_record(record, place.inside("record"), scene)
            case language.MeasureStep(measure=measure):
                plan_measure(measure, place.inside("measure"), scene)
            case language.ScanStep(scan=scan):
                plan_scan(scan, place.inside("scan"), scene)
