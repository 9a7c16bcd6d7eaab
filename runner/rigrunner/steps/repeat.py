"""`repeat`: steps are done several times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from rigrunner.api.hooks import StepRecord
from rigrunner.api.labels import CoordinateName
from rigrunner.api.settings import ListOf
from rigrunner.api.steps import StepSettings
from rigrunner.procedure.steps import Step

if TYPE_CHECKING:
    from rigrunner.plan.planning import Planning


class RepeatStep(StepSettings):
    """Steps are done several times."""

    times_: Annotated[int, Field(alias="times", ge=1, le=100_000)]
    """How often."""
    as_: Annotated[CoordinateName | None, Field(alias="as")] = None
    """What the times are called: recordings and rows carry it as a counter from 1."""
    steps: Annotated[ListOf[Step], Field(min_length=1)]
    """What is done each time."""

    def actions(self) -> int:
        """Return 0: it gives only what stands within it."""
        return 0

    def times(self) -> int:
        """Return how often."""
        return self.times_


def plan(repeat: RepeatStep, planning: Planning) -> None:
    """Write down what is done, for each time."""
    name, place = repeat.as_, planning.place
    if name and not planning.scene.coordinate(place, name, "counter", planning.path("as")):
        name = None
    for index in range(repeat.times_):
        at = place.time(index).at(name, index + 1) if name else place.time(index)
        planning.walker.steps(repeat.steps, at.inside("steps"))


STEP = StepRecord(
    name="repeat",
    help="Steps are done several times.",
    settings=RepeatStep,
    factory=plan,
    example="repeat: {times: 3, as: block, steps: [...]}",
    trial={"times": 2, "as": "block", "steps": [{"wait": {"time": "1 s"}}]},
)
