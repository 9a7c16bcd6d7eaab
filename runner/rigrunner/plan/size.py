"""How much a procedure asks for, before any of it is written out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.procedure.walk import SECTIONS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.api.steps import StepSettings
    from rigrunner.procedure import LoadedProcedure, Step
    from rigrunner.yamlfile.document import Path

    Weight = Callable[[StepSettings], int]


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
    return sum(_of_step(procedure, s, (*path, i), weight) for i, s in enumerate(steps))


def _of_step(procedure: LoadedProcedure, step: Step, path: Path, weight: Weight) -> int:
    called = procedure.called.get(path)
    inner = _sum(called, weight) if called else 0
    inner += _sum_steps(procedure, step.steps, (*path, step.kind, "steps"), weight)
    return weight(step.settings) + step.settings.times() * inner
