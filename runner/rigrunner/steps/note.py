"""`note`: a remark is put on record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.hooks import StepRecord
from rigrunner.api.steps import NOTHING, Action, Found, StepSettings
from rigrunner.yamlfile.names import Text

if TYPE_CHECKING:
    from rigrunner.api.steps import Doing, Planning


class NoteStep(StepSettings):
    """A remark is put on record, for those who read the report."""

    text: Text
    """The remark."""


@dataclass(frozen=True)
class Note(Action):
    """A remark is put on record."""

    kind = "note"
    text: str

    def do(self, step: str, doing: Doing) -> Found:
        """Put it on record."""
        doing.note(step, self.text)
        return NOTHING


def plan(note: NoteStep, planning: Planning) -> None:
    """Write down that a remark is put on record."""
    planning.emit(Note(note.text), "Put a note on record")


STEP = StepRecord(
    name="note",
    help="A remark is put on record, for those who read the report.",
    settings=NoteStep,
    factory=plan,
    example="note: {text: ...}",
    trial={"text": "The oil was changed."},
)
