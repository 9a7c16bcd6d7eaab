"""All steps of a procedure with their places, those within others included."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.procedure.model import Procedure
    from rigrunner.procedure.steps import Step
    from rigrunner.yamlfile.document import Path

SECTIONS = ("setup", "main", "teardown")


def steps_of(procedure: Procedure) -> Iterator[tuple[Path, Step]]:
    """Yield every step with its path in the document, such as ('main', 0, 'sweep', 'steps', 1)."""
    for section in SECTIONS:
        yield from _steps(getattr(procedure, section), (section,))


def _steps(steps: Sequence[Step], path: Path) -> Iterator[tuple[Path, Step]]:
    for index, step in enumerate(steps):
        at = (*path, index)
        yield at, step
        yield from _steps(step.steps, (*at, step.kind, "steps"))
