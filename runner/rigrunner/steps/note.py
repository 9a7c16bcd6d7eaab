"""`note`: a remark is recorded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.hooks import StepRecord
from rigrunner.api.names import Text
from rigrunner.api.steps import NOTHING, Action, StepResult, StepSettings

if TYPE_CHECKING:
    from rigrunner.api.steps import Doing, Planning


class NoteStep(StepSettings):
    """Records a remark for readers of the report."""

    text: Text
    """The remark."""


@dataclass(frozen=True)
class Note(Action):
    """Records a remark."""

    kind = "note"
    text: str

    def do(self, step: str, doing: Doing) -> StepResult:
        """Record it."""
        doing.note(step, self.text)
        return NOTHING


def plan(note: NoteStep, planning: Planning) -> None:
    """Plan the remark."""
    planning.emit(Note(note.text), "Record a note")


STEP = StepRecord(
    name="note",
    help="Records a remark for readers of the report.",
    settings=NoteStep,
    factory=plan,
    example="note: {text: ...}",
    trial={"text": "The oil was changed."},
)
