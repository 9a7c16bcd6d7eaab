"""What the panel's people want of a run, until the run looks."""

from __future__ import annotations

import threading
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, TypeVar

from rigrunner_panel.process.channel import ChannelClosedError
from rigrunner_panel.process.orders import (
    Abort,
    AskPause,
    CloseManual,
    Decide,
    GiveAnswer,
    PutOnRecord,
    RecordManually,
    SetManually,
    Stop,
)

if TYPE_CHECKING:
    from rigrunner.engine import Decision, Interference
    from rigrunner_panel.process.channel import Channel
    from rigrunner_panel.process.orders import Wish
    from rigrunner_panel.process.switch import Switch

LOOK_EVERY_S = 0.05
_T = TypeVar("_T")

GONE = "the panel is gone"


class Inbox:
    """Sorts what comes from the panel; filled by one thread, looked into by the run."""

    def __init__(self, channel: Channel, switch: Switch) -> None:
        self._channel = channel
        self._switch = switch
        self._answers: SimpleQueue[GiveAnswer] = SimpleQueue()
        self._decisions: SimpleQueue[Decision] = SimpleQueue()
        self._records: SimpleQueue[Interference] = SimpleQueue()
        self._wishes: SimpleQueue[Wish] = SimpleQueue()
        self._pause_by = ""
        self._then: Decision | None = None

    def start(self) -> None:
        """Begin to listen, in a thread that does not keep the process alive."""
        threading.Thread(target=self._listen, name="panel", daemon=True).start()

    @property
    def pause_wanted(self) -> str:
        """Who asks for a pause; empty while nobody does."""
        return self._pause_by

    def pause_granted(self) -> Decision | None:
        """Take note that the run is paused; return what was decided together with the pause.

        Older decisions are forgotten: a second click must not end the next pause.
        """
        then, self._then, self._pause_by = self._then, None, ""
        while _next(self._decisions, wait=False) is not None:
            continue
        return then

    def pause_ended(self) -> None:
        """Take note that the run goes on: nobody asks for that pause any more."""
        self._then, self._pause_by = None, ""

    def answer(self, prompt: int) -> GiveAnswer | None:
        """Wait a moment for the answer to a prompt; those to others are dropped."""
        found = _next(self._answers)
        return found if found is not None and found.prompt == prompt else None

    def decision(self) -> Decision | None:
        """Wait a moment for a decision."""
        return _next(self._decisions)

    def wish(self) -> Wish | None:
        """Return the next wish of the manual page, if there is one."""
        return _next(self._wishes, wait=False)

    def has_wish(self) -> bool:
        """Say whether somebody waits for the manual page to do something."""
        return not self._wishes.empty()

    def records(self) -> list[Interference]:
        """Return what is to be put on record."""
        found = []
        while (one := _next(self._records, wait=False)) is not None:
            found.append(one)
        return found

    def _listen(self) -> None:
        try:
            while True:
                self._take(self._channel.receive())
        except ChannelClosedError:
            self._switch.abort("panel", GONE)

    def _take(self, message: object) -> None:
        match message:
            case Stop(by=by, reason=reason):
                self._switch.stop(by, reason)
            case Abort(by=by, reason=reason):
                self._switch.abort(by, reason)
            case AskPause(by=by, then=then):
                self._then, self._pause_by = then, by
            case Decide(decision=decision):
                self._decisions.put(decision)
            case GiveAnswer():
                self._answers.put(message)
            case PutOnRecord(what=what):
                self._records.put(what)
            case SetManually() | RecordManually() | CloseManual():
                self._wishes.put(message)


def _next(queue: SimpleQueue[_T], *, wait: bool = True) -> _T | None:
    try:
        return queue.get(timeout=LOOK_EVERY_S) if wait else queue.get_nowait()
    except Empty:
        return None
