"""A folder of tapes: one for each instrument, one for the clock, one for answers of people."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections import defaultdict
from dataclasses import replace
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Self, TypeVar

from rigrunner.tape.device import taped

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.devices import Clock, Device, DeviceContext, StopToken, Wire
    from rigrunner.api.events import EventSink
    from rigrunner.engine import AnswerSource, Pauses
    from rigrunner.engine.answers import Ask, Confirm
    from rigrunner.tape.manifest import TapeManifest


class TapedAnswers:
    """An AnswerSource whose answers go over a wire."""

    def __init__(self, answers: AnswerSource, wire: Wire) -> None:
        self._answers = answers
        self._wire = wire

    @property
    def by(self) -> str:
        """Who answers, for the record."""
        return self._wire.exchange("who answers", lambda: self._answers.by)

    def confirm(self, step: str, question: Confirm) -> bool:
        """Return whether it is so."""
        return self._wire.exchange(f"confirm {step}", lambda: self._answers.confirm(step, question))

    def ask(self, step: str, question: Ask) -> str:
        """Return the answer."""
        return self._wire.exchange(f"ask {step}", lambda: self._answers.ask(step, question))


_T = TypeVar("_T")


class Calls(threading.local):
    """A Wire for the calls of a device, which only marks that one is running.

    A driver can have its own thread, such as one that listens to a serial line. Its readings of the
    clock happen at random times, with which no replay could agree.
    """

    running = False

    def exchange(self, request: str, perform: Callable[[], _T]) -> _T:  # noqa: ARG002  (a Wire's)
        """Return what `perform` does."""
        before, self.running = self.running, True
        try:
            return perform()
        finally:
            self.running = before


class CallClock:
    """A Clock that is recorded during the calls of a device in this thread only."""

    def __init__(self, taped: Clock, plain: Clock, calls: Calls) -> None:
        self._taped = taped
        self._plain = plain
        self._calls = calls

    @property
    def _clock(self) -> Clock:
        return self._taped if self._calls.running else self._plain

    def monotonic_s(self) -> float:
        """Return seconds since an arbitrary start."""
        return self._clock.monotonic_s()

    def utc(self) -> datetime:
        """Return the date and time, in UTC."""
        return self._clock.utc()

    def sleep(self, seconds: float) -> None:
        """Let that much time pass."""
        self._clock.sleep(seconds)


DEVICES = "devices"
"""Folder of the tapes of instruments, named by role, or 'role.part'."""
CLOCK, _ANSWERS = "clock", "answers"


class Tape(ABC):
    """Records or replays the devices of a station and everything else that a run depends on."""

    replays: bool

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._calls = defaultdict[str, Calls](Calls)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @abstractmethod
    def begin(self, manifest: TapeManifest) -> None:
        """State what is recorded or replayed, before any instrument is connected."""

    @abstractmethod
    def close(self) -> None:
        """Close all files; idempotent."""

    @abstractmethod
    def notes(self) -> Sequence[str]:
        """Return the remarks for the end, as text."""

    @property
    def began_utc(self) -> datetime | None:
        """Start of the replayed run; None if none is replayed."""
        return None

    @property
    def watches_drives(self) -> bool:
        """Whether drives are read back during readings."""
        return True

    @property
    def provenance(self) -> Mapping[str, str]:
        """The part of the provenance of the run about the tape."""
        return {}

    @property
    def listeners(self) -> Sequence[EventSink]:
        """Further listeners to the events of a run."""
        return ()

    def clock(self, plain: Clock) -> Clock:
        """Return the clock of a run."""
        return self._clock(CLOCK, inf, plain)

    def stop(self, plain: StopToken) -> StopToken:
        """Return the stop token of a run."""
        return self._stop(CLOCK, inf, plain)

    def answers(self, plain: AnswerSource) -> AnswerSource:
        """Return the answers of a run."""
        return TapedAnswers(plain, self._wire(_ANSWERS, inf))

    def with_wire(self, context: DeviceContext) -> DeviceContext:
        """Return the context with the tape as wire, and as clock during calls."""
        name, patience_s = _place(context)
        on_tape = self._clock(name, patience_s, context.clock)
        clock = CallClock(on_tape, context.clock, self._calls[name])
        return replace(context, wire=self._wire(name, patience_s), clock=clock)

    def with_call_mark(self, device: Device, context: DeviceContext) -> Device:
        """Return the device, with a mark of whether it is being called."""
        name, patience_s = _place(context)
        return taped(device, self._calls[name], partial(self._stop, name, patience_s))

    def at_calls(self, device: Device, context: DeviceContext) -> Device:
        """Return the device with the tape at its calls."""
        return taped(device, self._wire(*_place(context)))

    @abstractmethod
    def pauses(self, plain: Pauses | None) -> Pauses | None:
        """Return who can pause a run; None for no one."""

    @abstractmethod
    def _wire(self, name: str, patience_s: float) -> Wire:
        """Return the wire of that name, always the same."""

    @abstractmethod
    def _stop(self, name: str, patience_s: float, plain: StopToken) -> StopToken:
        """Return a stop token on the wire of that name."""

    @abstractmethod
    def _clock(self, name: str, patience_s: float, plain: Clock) -> Clock:
        """Return a clock on the wire of that name."""


def _place(context: DeviceContext) -> tuple[str, float]:
    """Return the name of the tape of a device, and the time limit of its calls."""
    # A part of a device, "role/part", is a file as well, not a folder.
    return f"{DEVICES}/{context.role.replace('/', '.')}", context.patience.answer_s
