"""Walks a procedure and writes down every single action."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner.api.coordinates import in_si
from rigrunner.api.quantity import LONGEST_S, Quantity, readable
from rigrunner.plan.actions import Phase
from rigrunner.plan.conditions import begin_choice, end_choice
from rigrunner.plan.draft import Draft, Place, Scene
from rigrunner.plan.drives import DriveStates
from rigrunner.plan.planning import Planning
from rigrunner.procedure.answers import Expected
from rigrunner.procedure.walk import SECTIONS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.steps import StepSettings
    from rigrunner.plan.bench import Bench
    from rigrunner.procedure import LoadedProcedure, Step
    from rigrunner.yamlfile.document import Path
    from rigrunner.yamlfile.problems import Problems

    Weight = Callable[[StepSettings], int]


MAX_ACTIONS = 100_000
"""A plan is kept whole: loops that were mistyped are refused before they fill the memory."""


def build(procedure: LoadedProcedure, bench: Bench, problems: Problems) -> Draft:
    """Return all actions of a procedure; what cannot be done is added to the problems."""
    actions = actions_in(procedure)
    if actions > MAX_ACTIONS:
        message = f"the procedure has {actions:,} actions, more than {MAX_ACTIONS:,}"
        hint = "check nested sweeps and repetitions"
        problems.add(procedure.document, ("main",), message, hint, key=True)
        problems.stop_if_any()
    answered = {name: input_.expected for name, input_ in procedure.inputs.items()}
    draft = Draft(recordings_in(procedure), answered=answered)
    drives = DriveStates(bench, procedure.document, problems)
    scene = Scene(procedure.document, procedure.folder, bench, drives, problems, draft)
    walker = _Walker(procedure, scene)
    for phase in Phase:
        walker.section(phase.value, Place(phase, (phase.value,), phase.value))
    seconds = sum(step.estimated_s for step in draft.steps)
    if seconds > LONGEST_S:
        most = readable(LONGEST_S, "time")
        message = f"the procedure would take {seconds:.3g} s; the limit is {most}"
        problems.add(procedure.document, ("main",), message, "check its repetitions", key=True)
    return draft


@dataclass(frozen=True, eq=False)
class _Walker:
    """Goes through the steps of one procedure file."""

    procedure: LoadedProcedure
    scene: Scene

    def section(self, name: str, place: Place) -> None:
        """Write down the actions of 'setup', 'main' or 'teardown'."""
        self.steps(getattr(self.procedure.model, name), place)

    def steps(self, steps: Sequence[Step], place: Place) -> None:
        """Write down the actions of steps, each as its kind plans it."""
        for index, step in enumerate(steps):
            at = self._with_labels(step, place.step(index).inside(step.kind))
            when, before = step.settings.when, self.scene.drives.values()
            chosen = begin_choice(when, at, self.scene) if when else None
            planning = Planning(step.settings, at, self.scene, self)
            step.record.factory(step.settings, planning)
            # After its own planning: only the steps that follow can hang on its answer.
            if name := step.settings.answered():
                self.scene.draft.answered[name] = getattr(step.settings, "expected", Expected())
            if when and chosen is not None:
                end_choice(chosen, when, at, self.scene, before)

    def _with_labels(self, step: Step, place: Place) -> Place:
        """Return the place of a step with the labels that it gives."""
        for name, written in step.settings.label.items():
            value, unit = in_si(written)
            kind = _kind_of(written)
            if self.scene.coordinate(place, name, kind, (*place.path, "label", name)):
                symbol = written.unit.symbol if isinstance(written, Quantity) else ""
                place = place.at(name, value, unit, symbol)
        return place

    def call(self, place: Place) -> None:
        """Write down another procedure's steps; in a teardown, all of them are teardown."""
        # By the place of the step; the place here ends with the key of its kind.
        called = self.procedure.called[place.path[:-1]]
        ending = place.phase is Phase.TEARDOWN
        calls = place.calls if ending else (*place.calls, place.label)
        bench = self.scene.bench.of(called)
        drives = self.scene.drives.of(bench, called.document)
        scene = replace(
            self.scene, document=called.document, folder=called.folder, bench=bench, drives=drives
        )
        for section in Phase:
            phase = section if section is Phase.TEARDOWN else place.phase
            within = f"{place.within}.{section}"
            at = place._replace(phase=phase, path=(section.value,), within=within, calls=calls)
            _Walker(called, scene).section(section.value, at)


def _kind_of(value: Quantity | Coordinate) -> str:
    """Return what the values of a label are, in a word."""
    match value:
        case Quantity():
            return value.dimension
        case bool():
            return "true or false"
        case str():
            return "text"
        case _:
            return "number"


def actions_in(procedure: LoadedProcedure) -> int:
    """Return how many actions the plan of a procedure would have."""
    return _sum(procedure, lambda step: step.actions())


def recordings_in(procedure: LoadedProcedure) -> int:
    """Return how many recordings a procedure asks for."""
    return _sum(procedure, lambda step: step.recordings())


def _sum(procedure: LoadedProcedure, weight: Weight) -> int:
    sections = ((section, getattr(procedure.model, section)) for section in SECTIONS)
    return sum(_sum_steps(procedure, steps, (section,), weight) for section, steps in sections)


def _sum_steps(
    procedure: LoadedProcedure, steps: Sequence[Step], path: Path, weight: Weight
) -> int:
    total = 0
    for index, step in enumerate(steps):
        at = (*path, index)
        called = procedure.called.get(at)
        inner = _sum(called, weight) if called else 0
        inner += _sum_steps(procedure, step.steps, (*at, step.kind, "steps"), weight)
        total += weight(step.settings) + step.settings.times() * inner
    return total
