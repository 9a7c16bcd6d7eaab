"""The person at the panel, as the engine knows one: who answers, and who pauses."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Literal

from rigrunner.api.events import Alarm
from rigrunner.bus import EventStamp
from rigrunner.engine import Choice
from rigrunner.engine.pausing import PauseWantedError
from rigrunner.engine.session import stopped
from rigrunner.procedure.answers import Expected
from rigrunner_panel.process.news import Answered, Asked, PausedNow, WentOn

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rigrunner.api.devices import Clock
    from rigrunner.api.events import EventSink
    from rigrunner.engine import Decision, Interference, Paused
    from rigrunner.engine.answers import Ask, Confirm
    from rigrunner.rig import Rig
    from rigrunner_panel.process.inbox import Inbox
    from rigrunner_panel.process.switch import Switch
    from rigrunner_panel.process.watched import WatchedChannels

YES_NO = Expected(choices=("yes", "no"))


class PanelAnswers:
    """Shows questions at the panel and waits for the answers; an AnswerSource."""

    def __init__(
        self,
        send: Callable[[object], None],
        inbox: Inbox,
        switch: Switch,
        operator: str,
        watched: WatchedChannels | None = None,
    ) -> None:
        self._watched = watched
        self.by = operator or "operator"
        self._send = send
        self._inbox = inbox
        self._switch = switch
        self._numbers = itertools.count(1)

    def confirm(self, step: str, question: Confirm) -> bool:
        """Return whether it is so; nothing is taken for granted."""
        return self._asked(step, "confirm", question, YES_NO) == "yes"

    def ask(self, step: str, question: Ask) -> str:
        """Return the answer; the panel has looked at it already."""
        return self._asked(step, "ask", question, question.expected)

    def _asked(
        self,
        step: str,
        kind: Literal["confirm", "ask"],
        question: Ask | Confirm,
        expected: Expected,
    ) -> str:
        number = next(self._numbers)
        self._send(Asked(number, step, kind, question.text, question.picture, expected))
        try:
            while (answer := self._inbox.answer(number)) is None:
                if self._watched is not None:
                    self._watched.look()
                if self._switch.is_set():
                    raise stopped(self._switch)
                if by := self._inbox.pause_wanted:
                    raise PauseWantedError("a pause was asked for", by)
        finally:
            self._send(Answered(number))
        self.by = answer.by
        return answer.text


class PanelPerson:
    """Shows at the panel how a rig was left; it is made safe at once, whoever is in front of it."""

    def __init__(self, take: EventSink, clock: Clock, operator: str) -> None:
        self.by = operator or "operator"
        self._take = take
        self._stamp = EventStamp(clock)

    def warn(self, text: str) -> None:
        """Raise an alarm on every screen."""
        self._take(self._stamp(Alarm, source="rig", text=text))

    def agrees(self, question: str) -> bool:  # noqa: ARG002  (the Protocol's)
        """Let the rig be made safe, as each preflight does."""
        return True


class PanelPauses:
    """Pauses that the panel asks for and ends; they also tell who took control."""

    def __init__(
        self,
        send: Callable[[object], None],
        inbox: Inbox,
        watched: WatchedChannels | None = None,
    ) -> None:
        self._send = send
        self._inbox = inbox
        self._watched = watched

    def show(self, rig: Rig) -> None:
        """Read the channels for the screen."""
        if self._watched is not None:
            self._watched.look(rig)

    def wanted(self) -> str:
        """Return who asks for a pause."""
        return self._inbox.pause_wanted

    def told(self) -> Iterable[Interference]:
        """Return what else people did."""
        return self._inbox.records()

    def decide(self, paused: Paused, watch: Callable[[], None]) -> Decision:
        """Show where the run is paused, and wait for a decision that may be taken."""
        decision = self._inbox.pause_granted()
        self._send(PausedNow(paused))
        while decision is None or decision.choice not in paused.choices:
            watch()
            decision = self._inbox.decision()
        if decision.choice is not Choice.NOTE:
            self._inbox.pause_ended()
            self._send(WentOn())
        return decision
