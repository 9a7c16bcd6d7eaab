"""A tape that is played back."""

from __future__ import annotations

import hashlib
from math import inf
from typing import TYPE_CHECKING

from rigrunner.api.results import REPLAYED
from rigrunner.clock import utc_text
from rigrunner.tape.clock import ReplayedClock
from rigrunner.tape.file import TapeFile
from rigrunner.tape.manifest import differences, read_manifest
from rigrunner.tape.pauses import ReplayedPauses
from rigrunner.tape.replaying import Replay, ReplayWire
from rigrunner.tape.stop import ReplayedStop, plain_stop
from rigrunner.tape.tape import CLOCK, Tape

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.devices import Clock, StopToken
    from rigrunner.engine import Pauses
    from rigrunner.tape.manifest import TapeManifest


class ReplayedTape(Tape):
    """A tape that is played back; raises DataError if the folder holds none."""

    replays = True

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.manifest = read_manifest(folder)
        self._replay = Replay()
        self._files: dict[str, TapeFile] = {}
        self._wires: dict[str, ReplayWire] = {}

    @property
    def began_utc(self) -> datetime:
        """Start of the replayed run."""
        return self.manifest.began_utc

    @property
    def watches_drives(self) -> bool:
        """Whether the drives of the recorded run were read back during readings."""
        return self.manifest.watches_drives

    @property
    def provenance(self) -> Mapping[str, str]:
        """The tape: its name, start, and a digest of everything replayed."""
        digest = hashlib.sha256()
        for name, file in sorted(self._files.items()):
            digest.update(f"{name} {file.sha256}\n".encode())
        began = utc_text(self.manifest.began_utc)
        name = self.folder.absolute().name
        return {REPLAYED: f"{name}, begun {began}, SHA-256 {digest.hexdigest()}"}

    def begin(self, manifest: TapeManifest) -> None:
        """Keep the differences in the set-up, to explain a difference later."""
        self._replay.hint = "; ".join(differences(self.manifest, manifest))

    def notes(self) -> Sequence[str]:
        """Return what was not requested from the tapes; after a difference, that."""
        if self._replay.difference:
            hint = f" ({self._replay.hint})" if self._replay.hint else ""
            return (f"{self._replay.difference}{hint}",)
        return tuple(text for wire in self._wires.values() if (text := wire.unrequested()))

    def close(self) -> None:
        """Close all files; no one waits for an answer any more."""
        self._replay.over.set()
        for file in self._files.values():
            file.close()

    def pauses(self, plain: Pauses | None) -> Pauses | None:  # noqa: ARG002  (the base's)
        """Return the recorded pauses, if pausing was possible."""
        return ReplayedPauses(self._wire(CLOCK, inf)) if self.manifest.attended else None

    def _wire(self, name: str, patience_s: float) -> ReplayWire:
        if name not in self._wires:
            file = self._files[name] = TapeFile(self.folder / f"{name}.jsonl")
            self._wires[name] = ReplayWire(file, self._replay, patience_s)
        return self._wires[name]

    def _stop(self, name: str, patience_s: float, plain: StopToken) -> StopToken:
        return ReplayedStop(plain_stop(plain), self._wire(name, patience_s))

    def _clock(self, name: str, patience_s: float, plain: Clock) -> Clock:  # noqa: ARG002  (the base's)
        return ReplayedClock(self._wire(name, patience_s), self.manifest.began_utc)
