"""`ramp`: a drive moves to a set-point at a rate, or over a time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api.hooks import StepRecord
from rigrunner.api.member import Member
from rigrunner.api.settings import AnyQuantity, PositiveDuration
from rigrunner.api.steps import NONE, Action, StepResult, StepSettings
from rigrunner.procedure.options import Repeatable, Retries, Timeout
from rigrunner.procedure.refusals import require_one

if TYPE_CHECKING:
    from rigrunner.api.devices import DriveInfo
    from rigrunner.api.quantity import Quantity
    from rigrunner.engine.session import Session
    from rigrunner.plan.planning import Planning

# A ramp at just the fastest rate of the drive must not fail by rounding.
_ROUNDING = 1 + 1e-9


class RampStep(StepSettings):
    """Moves a drive to a set-point at a rate, or over a time."""

    drive: Member
    """Role and drive, such as tester.load."""
    from_: Annotated[AnyQuantity | None, Field(alias="from")] = None
    """Start; by default the present set-point."""
    to: AnyQuantity
    """End."""
    rate: AnyQuantity | None = None
    """Rate, such as 100 N/s."""
    time: PositiveDuration | None = None
    """Duration."""
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        require_one(self, "rate", "time")
        return self


@dataclass(frozen=True)
class Ramp(Action):
    """Moves one drive from a start to an end, in its SI unit, over a time."""

    kind = "ramp"
    role: str
    drive: str
    start: float
    end: float
    unit: str
    duration_s: float

    @cached_property
    def moves(self) -> Member:
        """The drive."""
        return Member(self.role, self.drive)

    @property
    def moves_to(self) -> tuple[float, float]:
        """Start and end."""
        return (self.start, self.end)

    def do(self, step: str, doing: Session) -> StepResult:  # noqa: ARG002  (its errors name the drive)
        """Set the drive repeatedly, so that it follows the line from start to end."""
        actual = doing.ramp(self.role, self.drive, self.start, self.end, self.duration_s)
        return StepResult({self.moves: actual}, {self.moves: self.unit}, NONE)


def plan(ramp: RampStep, planning: Planning) -> None:
    """Plan the move."""
    drives = planning.scene.drives
    drive = _resolve(ramp, "to", ramp.to, planning)
    if drive is None or (ramp.from_ and not _resolve(ramp, "from", ramp.from_, planning)):
        return
    start = ramp.from_.si if ramp.from_ else drives.standing(ramp.drive, drive)
    # With `from` elsewhere than it stands, the drive is first set to there.
    before_s = drives.move(ramp.drive, drive, start)
    duration_s = _ramp_s(ramp, abs(ramp.to.si - start), drive, planning)
    drives.move(ramp.drive, drive, ramp.to.si, ramp.to.unit.symbol)
    action = Ramp(ramp.drive.role, ramp.drive.name, start, ramp.to.si, drive.unit, duration_s)
    text = f"Ramp {ramp.drive} to {ramp.to} in {duration_s:.3g} s"
    planning.emit(action, text, before_s + duration_s)


def _resolve(ramp: RampStep, end: str, quantity: Quantity, planning: Planning) -> DriveInfo | None:
    named_at, valued_at = planning.path("drive"), planning.path(end)
    return planning.scene.drives.resolve(ramp.drive, quantity, named_at, valued_at, key=False)


def _ramp_s(ramp: RampStep, distance: float, drive: DriveInfo, planning: Planning) -> float:
    """Return the duration of the ramp; one that the drive cannot follow is a problem."""
    if ramp.rate is not None:
        key = "rate"
        rate = planning.rate(ramp.rate, drive.unit, ramp.drive, (key,))
        seconds = distance / rate if rate else 0.0
    else:
        key, seconds = "time", ramp.time or 0.0
    fastest = drive.rate_per_s
    if fastest and seconds and distance > fastest * seconds * _ROUNDING:
        message = f"{ramp.drive} moves by {fastest:g} {drive.unit} in a second at most"
        hint = f"it needs {distance / fastest:.3g} s for this ramp"
        planning.complain((key,), message, hint)
    return seconds


STEP = StepRecord(
    name="ramp",
    help="Moves a drive to a set-point at a rate, or over a time.",
    settings=RampStep,
    factory=plan,
    example="ramp: {drive: role.drive, to: 1000 N, rate: 100 N/s}` or `time: 10 s",
    trial={"drive": "tester.load", "to": "100 N", "time": "2 s"},
)
