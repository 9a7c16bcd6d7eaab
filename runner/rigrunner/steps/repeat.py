"""`repeat`: steps are repeated a number of times, or until a value is beyond a bound."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api.conditions import Until, each_until
from rigrunner.api.hooks import StepRecord
from rigrunner.api.labels import CoordinateName
from rigrunner.api.settings import ListOf, OneOrSeveral
from rigrunner.api.steps import StepSettings
from rigrunner.procedure.refusals import refusal
from rigrunner.procedure.steps import Step

if TYPE_CHECKING:
    from rigrunner.plan.planning import Planning

_MOST = 100_000


class RepeatStep(StepSettings):
    """Repeats steps a number of times, or until a channel or a result is beyond a bound."""

    times_: Annotated[int | None, Field(alias="times", ge=1, le=_MOST)] = None
    """Number of repetitions."""
    until: OneOrSeveral[Until] = ()
    """Condition for ending, evaluated after each pass; of several, the first that is met."""
    at_most: Annotated[int | None, Field(ge=1, le=_MOST)] = None
    """Largest number of repetitions with `until`."""
    as_: Annotated[CoordinateName | None, Field(alias="as")] = None
    """Name of the counter, from 1, that recordings and rows carry."""
    steps: Annotated[ListOf[Step], Field(min_length=1)]
    """The steps to repeat."""

    @model_validator(mode="after")
    def _ends(self) -> Self:
        keys = [key for key, value in (("times", self.times_), ("until", self.until)) if value]
        if len(keys) != 1:
            got = "both" if keys else "neither"
            raise refusal(f"got {got}, expected one of: times, until")
        if bool(self.until) != bool(self.at_most):
            missing = "at_most" if self.until else "until"
            raise refusal(f"the key '{missing}' is missing", "they go together: at_most: 50")
        return self

    def actions(self) -> int:
        """Return the number of evaluations of the condition; the rest is inside."""
        return self.at_most or 0

    def times(self) -> int:
        """Return the largest number of repetitions."""
        return self.times_ or self.at_most or 0


def plan(repeat: RepeatStep, planning: Planning) -> None:
    """Plan each repetition."""
    from rigrunner.plan.conditions import end_until, plan_until  # noqa: PLC0415  (numpy: to check a procedure needs none)

    name, place, times = repeat.as_, planning.place, repeat.times()
    if name and not planning.scene.coordinate(place, name, "counter", planning.path("as")):
        name = None
    written = planning.scene.document.part(planning.path("until"))
    conditions: list[int] = []
    for index in range(times):
        at = place.time(index).at(name, index + 1) if name else place.time(index)
        planning.walker.steps(repeat.steps, at.inside("steps"))
        for key, until in each_until(repeat.until, written):
            condition = plan_until(until, key, (index + 1, times), planning)
            conditions += [] if condition is None else [condition]
    # How many steps each condition can leave out is known only now.
    end_until(conditions, planning.scene)


STEP = StepRecord(
    name="repeat",
    help="Repeats steps a number of times, or until a channel or a result is beyond a bound.",
    settings=RepeatStep,
    factory=plan,
    example="repeat: {times: 3, as: block, steps: [...]}`, or with `until: {channel: role.name,"
    " above: 60 °C}, at_most: 50",
    trial={"times": 2, "as": "block", "steps": [{"wait": {"time": "1 s"}}]},
)
