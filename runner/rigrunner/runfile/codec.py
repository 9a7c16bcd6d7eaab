"""Headers, events and sample blocks as bytes, and back."""

from __future__ import annotations

import json
import struct
from dataclasses import asdict, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api import events
from rigrunner.api.data import Block
from rigrunner.api.errors import DataError
from rigrunner.runfile.model import FORMAT, RunHeader

if TYPE_CHECKING:
    from collections.abc import Mapping

_LENGTH = struct.Struct("<I")
_KINDS: Mapping[str, type[events.Event]] = {
    kind.__name__: kind
    for kind in (
        events.RunStarted,
        events.StepStarted,
        events.Prompt,
        events.Answer,
        events.Note,
        events.Alarm,
        events.Intervention,
        events.StepEnded,
        events.RunEnded,
    )
}


def header_bytes(header: RunHeader) -> bytes:
    """Return a header as JSON with the format's version."""
    return _json({"format": FORMAT, **asdict(header)})


def header_from(data: bytes, source: str) -> RunHeader:
    """Return the header; raise DataError if a newer version wrote it."""
    document = json.loads(data)
    check_format(document.pop("format"), source)
    return RunHeader(**_known(RunHeader, document))


def check_format(version: int, source: str) -> None:
    """Raise DataError if `source` was written in a format that is newer than this program."""
    if version > FORMAT:
        raise DataError(
            f"{source} was written by a newer version of Rigrunner"
            f" (format {version}, this one reads up to {FORMAT})",
            hint="read it with that version",
        )


def event_text(event: events.Event) -> str:
    """Return an event as ASCII JSON. The truth of a simulator is left out: it is kept apart."""
    document = {field.name: getattr(event, field.name) for field in fields(event)}
    document.pop("truth", None)
    return json.dumps({"event": type(event).__name__, **document}, default=dict)


def event_from(text: str | bytes) -> events.Event | None:
    """Return the event; None for a kind that this version does not know."""
    document = json.loads(text)
    kind = _KINDS.get(document.pop("event"))
    if kind is None:
        return None
    if kind is events.RunEnded:
        document["outcome"] = events.Outcome(document["outcome"])
    if kind is events.Prompt:
        document["choices"] = tuple(document["choices"])
    return kind(**_known(kind, document))


def truth_bytes(recording: str, truth: Mapping[str, float]) -> bytes:
    """Return what a simulator knows of one recording."""
    return _json({"recording": recording, "truth": dict(truth)})


def truth_from(data: bytes) -> tuple[str, dict[str, float]]:
    """Return the recording's name and its truth."""
    document = json.loads(data)
    return document["recording"], document["truth"]


def block_bytes(recording: str, block: Block) -> tuple[bytes | memoryview, ...]:
    """Return a block of samples: a JSON head, then each channel as little-endian float64."""
    head = _json(
        {
            "recording": recording,
            "rate_hz": block.rate_hz,
            "first_sample": block.first_sample,
            "monotonic_s": block.monotonic_s,
            "samples": block.samples,
            "channels": list(block.channels),
        }
    )
    columns = (np.ascontiguousarray(values, "<f8") for values in block.channels.values())
    return (_LENGTH.pack(len(head)), head, *(column.data.cast("B") for column in columns))


def block_from(data: bytes) -> tuple[str, Block]:
    """Return the recording's name and the block."""
    (length,) = _LENGTH.unpack_from(data)
    start = _LENGTH.size + length
    head = json.loads(data[_LENGTH.size : start])
    samples, names = head["samples"], head["channels"]
    table = np.frombuffer(data, "<f8", samples * len(names), start).reshape(len(names), samples)
    channels = dict(zip(names, table, strict=True))
    return head["recording"], Block(
        head["rate_hz"], head["first_sample"], head["monotonic_s"], channels
    )


def _json(document: Mapping[str, Any]) -> bytes:
    return json.dumps(document).encode()


def _known(kind: type, document: Mapping[str, Any]) -> dict[str, Any]:
    names = {field.name for field in fields(kind)}
    return {name: value for name, value in document.items() if name in names}
