"""Recording a run on tape, and replaying it."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

from rigrunner import __version__
from rigrunner.api.errors import UsageError
from rigrunner.engine import Override
from rigrunner.tape import (
    RecordedTape,
    ReplayedTape,
    TapedFile,
    TapedOverride,
    TapedPlugin,
    TapeManifest,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from datetime import datetime
    from pathlib import Path

    from rigrunner.engine import AnswerSource
    from rigrunner.registry import Registry
    from rigrunner.run.prepare import Planned
    from rigrunner.station import LoadedStation
    from rigrunner.tape import Tape


def tape_for(record: Path | None, replay: Path | None) -> Tape | None:
    """Return the tape, if any; raise UsageError if both kinds are requested, or DataError."""
    if record is not None and replay is not None:
        raise UsageError("--record and --replay exclude each other", hint="give one of them")
    if record is not None:
        return RecordedTape(record)
    return None if replay is None else ReplayedTape(replay)


def on_tape(
    planned: Planned,
    tape: Tape,
    inputs: Mapping[str, str],
    overrides: Sequence[Override],
    answers: AnswerSource,
    *,
    attended: bool = False,
) -> tuple[Planned, AnswerSource]:
    """Begin the tape of a run; return the run with its clock on tape, and its answers so."""
    procedure = planned.procedure
    texts = [procedure.text, *(text for _, text in sorted(procedure.called_texts.items()))]
    manifest = manifest_of(planned.station, planned.registry, planned.clock.utc()).model_copy(
        update={
            # No YAML has a NUL: the digest also covers where each text ends.
            "procedure": TapedFile(id=procedure.model.id, sha256=_digest("\0".join(texts))),
            "attended": attended,
            "watches_drives": tape.watches_drives,
            "inputs": dict(inputs),
            "overrides": tuple(TapedOverride(**asdict(override)) for override in overrides),
        }
    )
    tape.begin(manifest)
    return replace(planned, clock=tape.clock(planned.clock)), tape.answers(answers)


def manifest_of(station: LoadedStation, registry: Registry, began: datetime) -> TapeManifest:
    """Return the manifest of a tape of the instruments of a station."""
    return TapeManifest(
        program=__version__,
        began_utc=began,
        station=TapedFile(id=station.model.id, sha256=station.digest),
        devices={
            role: TapedPlugin(
                plugin=device.plugin,
                provider=str(registry.find("device", device.plugin).provider),
                settings_sha256=_digest(json.dumps(device.settings, sort_keys=True, default=str)),
            )
            for role, device in station.model.devices.items()
        },
    )


def inputs_on(tape: Tape | None) -> dict[str, str]:
    """Return the inputs of the replayed run."""
    return dict(tape.manifest.inputs) if isinstance(tape, ReplayedTape) else {}


def overrides_on(tape: Tape | None) -> tuple[Override, ...]:
    """Return the overrides of the replayed run."""
    if not isinstance(tape, ReplayedTape):
        return ()
    return tuple(Override(**override.model_dump()) for override in tape.manifest.overrides)


def from_tape(tape: Tape | None) -> dict[str, str]:
    """Return the tape of a run from its provenance."""
    return {} if tape is None else dict(tape.provenance)


def mark_of(tape: Tape | None) -> str:
    """Return the mark of a replay, which has the same time and specimen as its run."""
    return "replay" if isinstance(tape, ReplayedTape) else ""


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
