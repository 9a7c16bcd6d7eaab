"""`settle`: wait until the motion is steady."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

from pydantic import model_validator

from rigrunner.api.hooks import StepRecord
from rigrunner.api.settings import PositiveDuration
from rigrunner.api.steps import NOTHING, Action, StepResult, StepSettings
from rigrunner.procedure.options import Cycles
from rigrunner.procedure.refusals import require_one

if TYPE_CHECKING:
    from rigrunner.api.steps import Doing
    from rigrunner.plan.planning import Planning


class SettleStep(StepSettings):
    """Waits until the motion is steady: a number of cycles, or a time."""

    cycles: Cycles | None = None
    """Number of cycles of the motion."""
    time: PositiveDuration | None = None
    """Duration."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        require_one(self, "cycles", "time")
        return self


@dataclass(frozen=True)
class Settle(Action):
    """Waits until the motion is steady."""

    kind = "settle"
    settles = True
    duration_s: float

    def do(self, step: str, doing: Doing) -> StepResult:  # noqa: ARG002  (there is nothing to report)
        """Wait."""
        doing.wait(self.duration_s)
        return NOTHING


def plan(settle: SettleStep, planning: Planning) -> None:
    """Plan the wait."""
    if settle.time is not None:
        planning.emit(Settle(settle.time), f"Settle for {settle.time:.3g} s", settle.time)
        return
    frequency_hz = planning.scene.drives.cycle_frequency_hz(None, planning.path("cycles"))
    if frequency_hz and settle.cycles:
        seconds = settle.cycles / frequency_hz
        count = settle.cycles
        text = f"Settle for {count} {'cycle' if count == 1 else 'cycles'} ({seconds:.3g} s)"
        planning.emit(Settle(seconds), text, seconds)


STEP = StepRecord(
    name="settle",
    help="Waits until the motion is steady: a number of cycles, or a time.",
    settings=SettleStep,
    factory=plan,
    example="settle: {cycles: 5}` or `settle: {time: 2 s}",
    trial={"time": "2 s"},
)
