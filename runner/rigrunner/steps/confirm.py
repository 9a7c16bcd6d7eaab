"""`confirm`: a person confirms a statement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError
from rigrunner.api.events import Answer, Prompt
from rigrunner.api.hooks import StepRecord
from rigrunner.api.names import Name, Text
from rigrunner.api.settings import YesNo
from rigrunner.api.steps import NOTHING, Action, StepResult, StepSettings
from rigrunner.procedure.answers import Expected
from rigrunner.procedure.questions import Picture

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.engine.session import Session
    from rigrunner.plan.planning import Planning

YES, NO = "yes", "no"


class ConfirmStep(StepSettings):
    """A person confirms a statement; 'no' stops the run, unless the answer is an input."""

    text: Text
    """The statement to confirm."""
    into: Name | None = None
    """The input that takes the answer, 'yes' or 'no'. The run continues with either."""
    picture: Picture = None
    unattended: YesNo | None = None
    """The answer with `--unattended`; without it the step needs a person."""

    def pictures(self) -> Iterable[tuple[str, str]]:
        """Return the picture, if there is one."""
        return [("picture", self.picture)] if self.picture else []

    def answered(self) -> str:
        """Return the input that the answer becomes."""
        return self.into or ""

    @property
    def expected(self) -> Expected:
        """The accepted answers."""
        return Expected(choices=(YES, NO))


@dataclass(frozen=True)
class Confirm(Action):
    """A person confirms a statement; 'no' stops the run, unless the answer is an input."""

    kind = "confirm"
    text: str
    unattended: bool | None
    picture: str = ""
    """The path of a picture to show; empty for none."""
    into: str = ""
    """The input that the answer becomes; '' for none."""

    @property
    def outcome_stands(self) -> bool:  # type: ignore[override]  # of some it does
        """Whether a resumed run keeps the answer: if it is an input."""
        return bool(self.into)

    def do(self, step: str, doing: Session) -> StepResult:
        """Ask; raise AbortedError for a 'no' that is not an input."""
        choices = (YES, NO)
        doing.emit(Prompt, step=step, text=self.text, picture=self.picture, choices=choices)
        with doing.rig.person():
            agreed = doing.answers.confirm(step, self)
        answer = YES if agreed else NO
        # Before a "no" ends the run: the answer is on record.
        doing.emit(Answer, step=step, text=answer, by=doing.answers.by, into=self.into)
        if self.into:
            doing.inputs[self.into] = answer
        elif not agreed:
            raise AbortedError(f"{step}: '{self.text}' was answered with no")
        return NOTHING


def plan(confirm: ConfirmStep, planning: Planning) -> None:
    """Plan the question; pictures are in the folder of the procedure."""
    picture = str(planning.scene.folder / confirm.picture) if confirm.picture else ""
    planning.emit(
        Confirm(confirm.text, confirm.unattended, picture, confirm.into or ""), confirm.text
    )


STEP = StepRecord(
    name="confirm",
    help="Asks a person to confirm a statement; 'no' stops the run.",
    settings=ConfirmStep,
    factory=plan,
    example="confirm: {text: ..., unattended: yes}",
    trial={"text": "Is the guard closed?", "unattended": True},
)
