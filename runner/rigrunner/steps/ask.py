"""`ask`: ask a person for a value."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner.api.events import Answer, Prompt
from rigrunner.api.hooks import StepRecord
from rigrunner.api.names import Name, Text
from rigrunner.api.steps import NOTHING, Action, StepResult, StepSettings
from rigrunner.procedure.answers import Expected
from rigrunner.procedure.questions import Picture, Question

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.engine.session import Session
    from rigrunner.plan.planning import Planning
    from rigrunner.procedure import Input


class AskStep(Question, StepSettings):
    """A person is asked for a value, which becomes the input named by `into`."""

    text: Text
    """The question."""
    into: Name
    """The input that the answer becomes."""
    picture: Picture = None

    def pictures(self) -> Iterable[tuple[str, str]]:
        """Return the picture, if there is one."""
        return [("picture", self.picture)] if self.picture else []

    def answered(self) -> str:
        """Return the input that the answer becomes."""
        return self.into


@dataclass(frozen=True)
class Ask(Action):
    """A person is asked for a value; `into` names the input that it becomes."""

    kind = "ask"
    outcome_stands = True
    text: str
    into: str
    unattended: str | None
    picture: str = ""
    """The path of a picture to show; empty for none."""
    expected: Expected = field(default_factory=Expected)

    def do(self, step: str, doing: Session) -> StepResult:
        """Ask until an answer is accepted."""
        expected = self.expected
        # Recorded first: the question is known also if no one answers.
        doing.emit(
            Prompt,
            step=step,
            text=self.text,
            picture=self.picture,
            choices=expected.choices,
            expected=expected.words,
        )
        with doing.rig.person():
            answer = expected.accept(doing.answers.ask(step, self))
        doing.emit(Answer, step=step, text=answer, by=doing.answers.by, into=self.into)
        doing.inputs[self.into] = answer
        return NOTHING


def question_of(name: str, question: Input) -> Ask:
    """Return the question for an input of the procedure."""
    return Ask(question.ask, name, question.unattended, expected=question.expected)


def plan(ask: AskStep, planning: Planning) -> None:
    """Plan the question; pictures are in the folder of the procedure."""
    picture = str(planning.scene.folder / ask.picture) if ask.picture else ""
    planning.emit(Ask(ask.text, ask.into, ask.unattended, picture, ask.expected), ask.text)


STEP = StepRecord(
    name="ask",
    help="Asks a person for a value, which becomes an input of the run.",
    settings=AskStep,
    factory=plan,
    example="ask: {text: ..., into: name}",
    trial={"text": "Room temperature", "into": "room", "unattended": "23"},
)
