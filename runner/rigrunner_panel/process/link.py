"""The job's link to the panel: receives commands, sends events and sections of the state."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from queue import Empty, SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from msgspec import structs

from rigrunner.api.events import Event, Samples, Scanned
from rigrunner_panel.process.channel import ChannelClosedError
from rigrunner_panel.process.messages import (
    Abort,
    Answer,
    CloseManual,
    Decide,
    Pause,
    PutOnRecord,
    RecordPoint,
    SetDrive,
    Show,
    Stop,
)

if TYPE_CHECKING:
    from rigrunner.engine import Decision, Interference
    from rigrunner_panel.process.channel import Channel
    from rigrunner_panel.process.messages import ByHand
    from rigrunner_panel.process.switch import Switch

LOOK_EVERY_S = 0.05
MOST_BLOCKS = 50
"""Most blocks that wait for a slow panel; more are dropped. The run file has all of them."""
_FLUSH_S = 10.0
_ROWS_EVERY_S = 0.05
"""Interval in s at which a point of a scan is sent; a scan may have thousands of points a second.
"""
GONE = "the panel is gone"
_T = TypeVar("_T")


class Commands:
    """Sorts commands of people at the panel. One thread writes, the run reads."""

    def __init__(self, channel: Channel, switch: Switch) -> None:
        self._channel = channel
        self._switch = switch
        self._answers: SimpleQueue[Answer] = SimpleQueue()
        self._decisions: SimpleQueue[Decision] = SimpleQueue()
        self._records: SimpleQueue[Interference] = SimpleQueue()
        self._by_hand: SimpleQueue[ByHand] = SimpleQueue()
        self._pause_by = ""
        self._then: Decision | None = None

    def start(self) -> None:
        """Start to receive, in a daemon thread."""
        threading.Thread(target=self._listen, name="panel", daemon=True).start()

    @property
    def pause_requested(self) -> str:
        """Who requests a pause; empty for no one."""
        return self._pause_by

    def pause_granted(self) -> Decision | None:
        """Store that the run is paused; return the decision sent with the pause.

        Older decisions are dropped: a second click must not end the next pause.
        """
        then, self._then, self._pause_by = self._then, None, ""
        while _next(self._decisions, wait=False) is not None:
            continue
        return then

    def pause_ended(self) -> None:
        """Store that the run continues: the pause request is done."""
        self._then, self._pause_by = None, ""

    def answer(self, prompt: int) -> Answer | None:
        """Wait briefly for the answer to a prompt; answers to other prompts are dropped."""
        answer = _next(self._answers)
        return answer if answer is not None and answer.prompt == prompt else None

    def decision(self) -> Decision | None:
        """Wait briefly for a decision."""
        return _next(self._decisions)

    def by_hand(self) -> ByHand | None:
        """Return the next manual command, if any."""
        return _next(self._by_hand, wait=False)

    def has_by_hand(self) -> bool:
        """Return whether a manual command is waiting."""
        return not self._by_hand.empty()

    def records(self) -> list[Interference]:
        """Return what is to be recorded in the run."""
        records = []
        while (record := _next(self._records, wait=False)) is not None:
            records.append(record)
        return records

    def _listen(self) -> None:
        try:
            while True:
                self._take(self._channel.receive())
        except ChannelClosedError:
            self._switch.abort("panel", GONE)

    def _take(self, command: object) -> None:
        match command:
            case Stop(by=by, reason=reason):
                self._switch.stop(by, reason)
            case Abort(by=by, reason=reason):
                self._switch.abort(by, reason)
            case Pause(by=by, then=then):
                self._then, self._pause_by = then, by
            case Decide(decision=decision):
                self._decisions.put(decision)
            case Answer():
                self._answers.put(command)
            case PutOnRecord(what=what):
                self._records.put(what)
            case SetDrive() | RecordPoint() | CloseManual():
                self._by_hand.put(command)


def _next(queue: SimpleQueue[_T], *, wait: bool = True) -> _T | None:
    try:
        return queue.get(timeout=LOOK_EVERY_S) if wait else queue.get_nowait()
    except Empty:
        return None


class Sender:
    """Sends in its own thread, so that the run never waits; an event sink.

    Nothing is sent once the panel has closed.
    """

    def __init__(self, channel: Channel, most_blocks: int = MOST_BLOCKS) -> None:
        self._channel = channel
        self._most_blocks = most_blocks
        self._queue: SimpleQueue[object] = SimpleQueue()
        self._blocks = 0
        self._row: Scanned | None = None
        self._rows_due_s = 0.0
        self._thread = threading.Thread(target=self._work, name="to the panel", daemon=True)
        self._thread.start()

    def send(self, message: object) -> None:
        """Send a message after the earlier ones."""
        self._queue.put(message)

    def send_unless_behind(self, message: object) -> None:
        """Send a message that is only useful now, unless too many earlier ones are waiting."""
        if self._queue.qsize() < MOST_BLOCKS:
            self.send(message)

    def __call__(self, event: Event) -> None:
        """Send an event of the run; of samples and scans, only as many as a screen can show."""
        if isinstance(event, Scanned):
            self._send_row(event)
            return
        if self._row is not None:
            self.send(self._row)
            self._row = None
        if not isinstance(event, Samples):
            self.send(event)
        elif self._blocks < self._most_blocks:
            self._blocks += 1
            self.send(_as_float32(event))

    def _send_row(self, row: Scanned) -> None:
        """Send a point from time to time, and the last one before the next event."""
        now_s = monotonic()
        self._row = row
        if now_s >= self._rows_due_s:
            self.send(row)
            self._row, self._rows_due_s = None, now_s + _ROWS_EVERY_S

    def end(self) -> None:
        """Send nothing after the remaining messages."""
        self._queue.put(None)

    def close(self) -> None:
        """Send the remaining messages."""
        self.end()
        self._thread.join(_FLUSH_S)

    def _work(self) -> None:
        is_open = True
        while (message := self._queue.get()) is not None:
            if isinstance(message, Samples):
                self._blocks -= 1
            if is_open:
                is_open = self._try_send(message)

    def _try_send(self, message: object) -> bool:
        try:
            self._channel.send(message)
        except ChannelClosedError:
            return False
        return True


def _as_float32(event: Samples) -> Samples:
    """Return the block in float32, which is precise enough for a screen."""
    channels: dict[str, Any] = {
        name: np.asarray(values, np.float32) for name, values in event.block.channels.items()
    }
    return structs.replace(event, block=replace(event.block, channels=channels))


@dataclass(frozen=True)
class Link:
    """Both directions of the link, and the switch that ends the job."""

    commands: Commands
    sender: Sender
    switch: Switch

    def show(self, **sections: Any) -> None:
        """Change sections of the state."""
        self.sender.send(Show(sections))
