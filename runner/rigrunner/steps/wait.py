"""`wait`: wait for a time, independent of the motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.hooks import StepRecord
from rigrunner.api.names import Text
from rigrunner.api.settings import PositiveDuration
from rigrunner.api.steps import NOTHING, Action, StepResult, StepSettings

if TYPE_CHECKING:
    from rigrunner.api.steps import Doing, Planning


class WaitStep(StepSettings):
    """Waits for a time."""

    time: PositiveDuration
    """Duration."""
    text: Text | None = None
    """Reason, as text."""


@dataclass(frozen=True)
class Wait(Action):
    """Waits for a time."""

    kind = "wait"
    duration_s: float

    def do(self, step: str, doing: Doing) -> StepResult:  # noqa: ARG002  (there is nothing to report)
        """Wait."""
        doing.wait(self.duration_s)
        return NOTHING


def plan(wait: WaitStep, planning: Planning) -> None:
    """Plan the wait."""
    text = f"Wait for {wait.time:.3g} s{f': {wait.text}' if wait.text else ''}"
    planning.emit(Wait(wait.time), text, wait.time)


STEP = StepRecord(
    name="wait",
    help="Waits for a time.",
    settings=WaitStep,
    factory=plan,
    example="wait: {time: 5 min}",
    trial={"time": "2 s"},
)
