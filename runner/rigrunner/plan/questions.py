"""The steps that ask or tell a person something: confirm, ask, note."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.plan.actions import Ask, Confirm, Note
from rigrunner.procedure import steps as language

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.plan.draft import Place, Scene
    from rigrunner.procedure.questions import Input


def plan_question(
    step: language.ConfirmStep | language.AskStep | language.NoteStep,
    place: Place,
    folder: Path,
    scene: Scene,
) -> None:
    """Write down what a person is asked or told; pictures are in the procedure's folder."""
    match step:
        case language.ConfirmStep(confirm=confirm):
            picture = _picture(folder, confirm.picture)
            action = Confirm(confirm.text, confirm.unattended, picture)
            scene.emit(place.inside("confirm"), action, confirm.text)
        case language.AskStep(ask=ask):
            picture = _picture(folder, ask.picture)
            request = Ask(ask.text, ask.into, ask.unattended, picture, ask.expected)
            scene.emit(place.inside("ask"), request, ask.text)
        case language.NoteStep(note=note):
            scene.emit(place.inside("note"), Note(note.text), "Put a note on record")


def question_of(name: str, wanted: Input) -> Ask:
    """Return the question for an input that is asked at the start."""
    return Ask(wanted.ask, name, wanted.unattended, expected=wanted.expected)


def _picture(folder: Path, name: str | None) -> str:
    return str(folder / name) if name else ""
