"""A tape that is being recorded."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.tape.clock import RecordedClock
from rigrunner.tape.manifest import NAME
from rigrunner.tape.pauses import RecordedPauses
from rigrunner.tape.recording import RecordingWire, Trouble
from rigrunner.tape.stop import RecordedStop, plain_stop
from rigrunner.tape.tape import CLOCK, DEVICES, Tape

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rigrunner.api.devices import Clock, StopToken
    from rigrunner.api.events import Event, EventSink
    from rigrunner.engine import Pauses
    from rigrunner.tape.manifest import TapeManifest


class RecordedTape(Tape):
    """A tape that is being recorded into a new folder; raises DataError if the folder has files.

    Once begun, an error of the tape does not stop the run: it raises one alarm.
    """

    replays = False

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise DataError(
                f"{folder} exists already: a tape is never overwritten",
                hint="name a new folder, or remove that one",
            )
        self._trouble = Trouble()
        self._wires: dict[str, RecordingWire] = {}

    def begin(self, manifest: TapeManifest) -> None:
        """Create the folder and the manifest; raise DataError if that fails."""
        try:
            (self.folder / DEVICES).mkdir(parents=True, exist_ok=True)
            text = manifest.model_dump_json(indent=2)
            (self.folder / NAME).write_text(text + "\n", encoding="utf-8")
        except OSError as error:
            raise DataError(
                f"cannot make the tape {self.folder}: {error.strerror or error}",
                hint="nothing was started; name a folder that can be written",
            ) from error

    @property
    def listeners(self) -> Sequence[EventSink]:
        """The listener that raises the alarm."""
        return (_Watch(self._trouble),)

    def notes(self) -> Sequence[str]:
        """Return problems of the tape."""
        if self._trouble.text:
            return (f"the tape {self.folder} is incomplete: {self._trouble.text}",)
        return ()

    def close(self) -> None:
        """Close all files."""
        for wire in self._wires.values():
            wire.close()

    def pauses(self, plain: Pauses | None) -> Pauses | None:
        """Return pauses that are recorded."""
        return None if plain is None else RecordedPauses(plain, self._wire(CLOCK, inf))

    def _wire(self, name: str, patience_s: float) -> RecordingWire:  # noqa: ARG002  (the base's)
        if name not in self._wires:
            self._wires[name] = RecordingWire(self.folder / f"{name}.jsonl", self._trouble)
        return self._wires[name]

    def _stop(self, name: str, patience_s: float, plain: StopToken) -> StopToken:
        return RecordedStop(plain_stop(plain), self._wire(name, patience_s))

    def _clock(self, name: str, patience_s: float, plain: Clock) -> Clock:
        return RecordedClock(plain, self._wire(name, patience_s))


class _Watch:
    """A listener that fails once the tape has: the bus raises an alarm and drops it."""

    __name__ = "the tape"

    def __init__(self, trouble: Trouble) -> None:
        self._trouble = trouble

    def __call__(self, event: Event) -> None:  # noqa: ARG002  (a listener's)
        if self._trouble.text:
            raise DataError(f"{self._trouble.text}; the run continues without it")
