"""`group`: steps that belong together are executed once, under common labels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from rigrunner.api.hooks import StepRecord
from rigrunner.api.settings import ListOf
from rigrunner.api.steps import StepSettings
from rigrunner.procedure.steps import Step

if TYPE_CHECKING:
    from rigrunner.plan.planning import Planning


class GroupStep(StepSettings):
    """Executes steps once, with the labels of the group."""

    steps: Annotated[ListOf[Step], Field(min_length=1)]
    """The steps."""

    def actions(self) -> int:
        """Return 0: it has only the actions inside it."""
        return 0


def plan(group: GroupStep, planning: Planning) -> None:
    """Plan the steps."""
    planning.walker.steps(group.steps, planning.place.inside("steps"))


STEP = StepRecord(
    name="group",
    help="Executes steps once, with common labels.",
    settings=GroupStep,
    factory=plan,
    example="group: {label: {phase: final}, steps: [...]}",
    trial={"label": {"phase": "final"}, "steps": [{"wait": {"time": "2 s"}}]},
)
