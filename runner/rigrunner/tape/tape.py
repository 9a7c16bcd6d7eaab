"""A folder with tapes: one for each instrument, one for the clock, one for persons' answers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import defaultdict
from dataclasses import replace
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Self

from rigrunner.tape.answers import TapedAnswers
from rigrunner.tape.calls import CallClock, Calls
from rigrunner.tape.device import taped

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.devices import Clock, Device, DeviceContext, StopToken, Wire
    from rigrunner.api.events import EventSink
    from rigrunner.engine import AnswerSource, Pauses
    from rigrunner.tape.manifest import TapeManifest

DEVICES = "devices"
"""The folder of the instruments' tapes, each named by role, or 'role.part'."""
CLOCK, _ANSWERS = "clock", "answers"


class Tape(ABC):
    """A Tap for the devices of a station, with all else that a run depends on."""

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
        """Say what is recorded or replayed, before any instrument is connected."""

    @abstractmethod
    def close(self) -> None:
        """Close all files; idempotent."""

    @abstractmethod
    def notes(self) -> Sequence[str]:
        """Return what is to be told at the end, in words."""

    @property
    def began_utc(self) -> datetime | None:
        """When the run began that is replayed; None where none is."""
        return None

    @property
    def watches_drives(self) -> bool:
        """Whether the drives of the run are read back beside each reading."""
        return True

    @property
    def provenance(self) -> Mapping[str, str]:
        """What a run is to say of the tape for ever."""
        return {}

    @property
    def listeners(self) -> Sequence[EventSink]:
        """Those who are to hear of the events of a run."""
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

    def wired(self, context: DeviceContext) -> DeviceContext:
        """Return the context with the tape for its wire, and for its clock while it is called."""
        name, patience_s = _place(context)
        on_tape = self._clock(name, patience_s, context.clock)
        clock = CallClock(on_tape, context.clock, self._calls[name])
        return replace(context, wire=self._wire(name, patience_s), clock=clock)

    def called(self, device: Device, context: DeviceContext) -> Device:
        """Return the device, of which it is known while it is called."""
        name, patience_s = _place(context)
        return taped(device, self._calls[name], partial(self._stop, name, patience_s))

    def whole(self, device: Device, context: DeviceContext) -> Device:
        """Return the device with the tape at its calls."""
        return taped(device, self._wire(*_place(context)))

    @abstractmethod
    def pauses(self, plain: Pauses | None) -> Pauses | None:
        """Return who may pause a run; None where nobody may."""

    @abstractmethod
    def _wire(self, name: str, patience_s: float) -> Wire:
        """Return the wire of that name, the same each time."""

    @abstractmethod
    def _stop(self, name: str, patience_s: float, plain: StopToken) -> StopToken:
        """Return a stop token on the wire of that name."""

    @abstractmethod
    def _clock(self, name: str, patience_s: float, plain: Clock) -> Clock:
        """Return a clock on the wire of that name."""


def _place(context: DeviceContext) -> tuple[str, float]:
    """Return the name of a device's tape, and how long the device is waited for."""
    return f"{DEVICES}/{context.role.replace('/', '.')}", context.patience.answer_s
