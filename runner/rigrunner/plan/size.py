"""How much a procedure asks for, before any of it is written out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.procedure import steps as language
from rigrunner.procedure.walk import SECTIONS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.procedure import LoadedProcedure
    from rigrunner.yamlfile.document import Path

    Weight = Callable[[language.Step], int]


def actions_in(procedure: LoadedProcedure) -> int:
    """Return how many actions the plan of a procedure would have."""
    return _sum(procedure, _actions_of)


def recordings_in(procedure: LoadedProcedure) -> int:
    """Return how many recordings a procedure asks for."""
    return _sum(procedure, lambda step: int(isinstance(step, language.RecordStep)))


def _sum(procedure: LoadedProcedure, weight: Weight) -> int:
    sections = ((section, getattr(procedure.model, section)) for section in SECTIONS)
    return sum(_sum_steps(procedure, steps, (section,), weight) for section, steps in sections)


def _sum_steps(
    procedure: LoadedProcedure, steps: Sequence[language.Step], path: Path, weight: Weight
) -> int:
    return sum(_of_step(procedure, s, (*path, i), weight) for i, s in enumerate(steps))


def _of_step(procedure: LoadedProcedure, step: language.Step, path: Path, weight: Weight) -> int:
    match step:
        case language.SweepStep(sweep=sweep):
            inner = _sum_steps(procedure, sweep.steps, (*path, "sweep", "steps"), weight)
            return len(sweep.over) * (weight(step) + inner)
        case language.RepeatStep(repeat=repeat):
            inner = _sum_steps(procedure, repeat.steps, (*path, "repeat", "steps"), weight)
            return repeat.times * inner
        case language.CallStep():
            return _sum(procedure.called[path], weight)
        case _:
            return weight(step)


def _actions_of(step: language.Step) -> int:
    match step:
        case language.SetStep():
            return len(step.set.drives)
        case language.ScanStep():
            return len(step.scan.over)
        case _:
            return 1
