"""`sweep`: a drive is set to a list of set-points, and steps are executed at each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from rigrunner.api.hooks import StepRecord
from rigrunner.api.member import Member
from rigrunner.api.settings import AnyQuantity, ListOf
from rigrunner.api.steps import StepSettings
from rigrunner.procedure.steps import Step
from rigrunner.steps.set_drives import SetDrive

if TYPE_CHECKING:
    from rigrunner.plan.planning import Planning


class SweepStep(StepSettings):
    """Sets a drive to each of a list of set-points, and executes steps there."""

    set: Member
    """Role and drive, such as tester.frequency."""
    over: Annotated[ListOf[AnyQuantity], Field(min_length=1)]
    """The set-points in order."""
    steps: Annotated[ListOf[Step], Field(min_length=1)]
    """The steps at each set-point."""

    def actions(self) -> int:
        """Return the number of times that the drive is set."""
        return len(self.over)

    def times(self) -> int:
        """Return the number of set-points."""
        return len(self.over)


def plan(sweep: SweepStep, planning: Planning) -> None:
    """Plan drive and steps for each set-point."""
    # A sweep within a loop sets the same each time.
    sets: dict[int, tuple[SetDrive, str]] = planning.scene.cached(planning.place, "sets", dict)
    for index, quantity in enumerate(sweep.over):
        at = planning.place.time(index)
        moved = planning.move(sweep.set, quantity, ("set",), ("over", index))
        if moved is not None:
            if index not in sets:
                action = SetDrive(sweep.set.role, sweep.set.name, quantity.si, moved[0])
                sets[index] = action, f"Set {sweep.set} to {quantity}"
            planning.emit(*sets[index], moved[1], at=at.inside("set"))
        # Also at an invalid set-point: all problems are reported at once.
        planning.walker.steps(sweep.steps, at.inside("steps"))


STEP = StepRecord(
    name="sweep",
    help="Sets a drive to a list of set-points, and executes steps at each.",
    settings=SweepStep,
    factory=plan,
    example="sweep: {set: role.drive, over: [1 Hz, 2 Hz], steps: [...]}",
    trial={
        "set": "tester.load",
        "over": ["0 N", "100 N"],
        "steps": [{"wait": {"time": "1 s"}}],
    },
)
