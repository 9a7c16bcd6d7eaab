"""The person at the panel, as the engine's interfaces need one: answers and pauses."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Literal

from rigrunner.api.events import Alarm
from rigrunner.bus import EventStamp
from rigrunner.engine import Choice
from rigrunner.engine.pausing import PauseRequestedError
from rigrunner.engine.session import stopped
from rigrunner.procedure.answers import Expected
from rigrunner_panel.view.sections import PauseView, PromptView

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rigrunner.api.devices import Clock
    from rigrunner.api.events import EventSink
    from rigrunner.engine import Decision, Interference, Paused
    from rigrunner.engine.answers import Ask, Confirm
    from rigrunner.rig import Rig
    from rigrunner_panel.process.link import Link
    from rigrunner_panel.process.watched import WatchedChannels

YES_NO = Expected(choices=("yes", "no"))


class PanelAnswers:
    """Shows questions at the panel and waits for the answers; an AnswerSource."""

    def __init__(self, link: Link, operator: str, watched: WatchedChannels | None = None) -> None:
        self.by = operator or "operator"
        self._link = link
        self._watched = watched
        self._numbers = itertools.count(1)

    def confirm(self, step: str, question: Confirm) -> bool:
        """Return whether it is confirmed; there is no default."""
        return self._prompt(step, "confirm", question, YES_NO) == "yes"

    def ask(self, step: str, question: Ask) -> str:
        """Return the answer, which the panel has validated."""
        return self._prompt(step, "ask", question, question.expected)

    def _prompt(
        self,
        step: str,
        kind: Literal["confirm", "ask"],
        question: Ask | Confirm,
        expected: Expected,
    ) -> str:
        number = next(self._numbers)
        prompt = PromptView(
            id=number,
            step=step,
            text=question.text,
            kind=kind,
            choices=expected.choices,
            expected=expected.words,
            unit=expected.unit,
            picture=question.picture,
            accepts=expected,
        )
        self._link.show(prompt=prompt)
        try:
            while (answer := self._link.commands.answer(number)) is None:
                if self._watched is not None:
                    self._watched.look()
                if self._link.switch.is_set():
                    raise stopped(self._link.switch)
                if by := self._link.commands.pause_requested:
                    raise PauseRequestedError("pause requested", by)
        finally:
            self._link.show(prompt=None)
        self.by = answer.by
        return answer.text


class PanelPerson:
    """Shows how a rig was left; it is made safe without asking."""

    def __init__(self, take: EventSink, clock: Clock, operator: str) -> None:
        self.by = operator or "operator"
        self._take = take
        self._stamp = EventStamp(clock)

    def warn(self, text: str) -> None:
        """Raise an alarm on every screen."""
        self._take(self._stamp(Alarm, source="rig", text=text))

    def agrees(self, question: str) -> bool:  # noqa: ARG002  (the Protocol's)
        """Return that the rig may be made safe, as each preflight does."""
        return True


class PanelPauses:
    """Pauses requested and ended at the panel, and changes of control."""

    def __init__(self, link: Link, watched: WatchedChannels | None = None) -> None:
        self._link = link
        self._watched = watched

    def show(self, rig: Rig) -> None:
        """Read the channels for the screen."""
        if self._watched is not None:
            self._watched.look(rig)

    def requested_by(self) -> str:
        """Return who requests a pause."""
        return self._link.commands.pause_requested

    def new_actions(self) -> Iterable[Interference]:
        """Return what else people did."""
        return self._link.commands.records()

    def decide(self, paused: Paused, watch: Callable[[], None]) -> Decision:
        """Show where the run is paused, and wait for a valid decision."""
        decision = self._link.commands.pause_granted()
        view = PauseView(
            step=paused.step,
            point=paused.point,
            reason=paused.reason,
            moving=paused.moving,
            choices=tuple(str(choice) for choice in paused.choices),
        )
        self._link.show(pause=view)
        while decision is None or decision.choice not in paused.choices:
            watch()
            decision = self._link.commands.decision()
        if decision.choice is not Choice.NOTE:
            self._link.commands.pause_ended()
            self._link.show(pause=None)
        return decision
