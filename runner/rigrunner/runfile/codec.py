"""Encode headers, events and blocks of samples as bytes, and decode them."""

from __future__ import annotations

import json
import struct
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, Union

import msgspec
import numpy as np

from rigrunner.api import events
from rigrunner.api.data import Block
from rigrunner.api.errors import DataError
from rigrunner.runfile.compressed import LongText
from rigrunner.runfile.journal import Kind
from rigrunner.runfile.model import FORMAT, RunHeader

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

_T = TypeVar("_T")
_LENGTH = struct.Struct("<I")
KINDS: Mapping[str, type[events.Event]] = {
    kind.__name__: kind
    for kind in (
        events.RunStarted,
        events.StepStarted,
        events.Prompt,
        events.Answer,
        events.Note,
        events.LimitMissed,
        events.Alarm,
        events.InterlockTripped,
        events.InterlockCleared,
        events.MadeSafe,
        events.Intervention,
        events.Scanned,
        events.StepEnded,
        events.RunEnded,
    )
}
"""The stored kinds of events, by name."""
_STORED_EVENT: Any = Union[tuple(KINDS.values())]  # noqa: UP007  (of a tuple)
_from_json: Callable[[str | bytes], events.Event] = msgspec.json.Decoder(_STORED_EVENT).decode
_from_packed: Callable[[bytes], events.Event] = msgspec.msgpack.Decoder(_STORED_EVENT).decode
"""Fast decoders. What they refuse is decoded again: an unknown kind, or JSON with not-a-number."""


@dataclass(frozen=True, kw_only=True)
class _BlockHead:
    """The head before the samples of a block."""

    recording: str
    rate_hz: Annotated[float, msgspec.Meta(gt=0)]
    first_sample: int
    monotonic_s: float
    samples: Annotated[int, msgspec.Meta(ge=0)]
    channels: tuple[str, ...]


def header_bytes(header: RunHeader) -> bytes:
    """Return a header as JSON with the version of the format, without the text of the plan."""
    document = {"format": FORMAT, **asdict(header)}
    del document["plan_text"]
    return _json(document)


def header_from(data: bytes, source: str) -> tuple[RunHeader, int]:
    """Return the header and the version of its format; raise DataError for a newer version.

    Headers of earlier versions have the text of the plan in them.
    """
    document = _object(data)
    version = document.pop("format", None)
    if not isinstance(version, int):
        raise DataError(f"{source} does not state its format")
    check_format(version, source)
    try:
        plan = LongText.of(_convert(str, document.pop("plan_text", "")))
    except UnicodeEncodeError as error:
        raise DataError(f"a record of the run is invalid: {error}") from error
    return replace(_convert(RunHeader, document), plan_text=plan), version


def check_format(version: int, source: str) -> None:
    """Raise DataError if `source` was written in a format newer than this program."""
    if version > FORMAT:
        raise DataError(
            f"{source} was written by a newer version of Rigrunner"
            f" (format {version}, this one reads up to {FORMAT})",
            hint="read it with that version",
        )


def _plain(value: Any) -> str | dict[str, Any]:
    """Return a value that msgspec cannot encode: a Member as text, another mapping as a dict."""
    return str(value) if isinstance(value, str) else dict(value)


packed = msgspec.msgpack.Encoder(enc_hook=_plain).encode
"""Return a value as MessagePack."""


def event_record(event: events.Event) -> tuple[Kind, bytes]:
    """Return an event as a journal record: as MessagePack, or as JSON if that is impossible.

    The truth of a simulator is left out: it is stored separately.
    """
    if getattr(event, "truth", None):
        event = msgspec.structs.replace(event, truth={})
    try:
        return Kind.PACKED, packed(event)
    except (UnicodeEncodeError, OverflowError):  # half of a surrogate pair; more than 64 bits
        return Kind.EVENT, event_text(event).encode()


def event_text(event: events.Event) -> str:
    """Return an event as JSON in ASCII, without the truth of a simulator."""
    document = msgspec.to_builtins(event, enc_hook=_plain)
    document.pop("truth", None)
    # In ASCII, as the columns of events in the run file are.
    return json.dumps(document)


def event_from(text: str | bytes) -> events.Event | None:
    """Return the event in a JSON text; None for a kind that this version does not know."""
    try:
        return _from_json(text)
    except (msgspec.DecodeError, UnicodeError, RecursionError):
        return _event(_object(text))


def event_unpacked(data: bytes) -> events.Event | None:
    """Return the event in a MessagePack record; None for a kind that this version does not know."""
    try:
        return _from_packed(data)
    except (msgspec.DecodeError, UnicodeError, RecursionError):
        pass  # not `suppress`, which takes a third of the time of all this
    try:
        return _event(_convert(dict[str, Any], msgspec.msgpack.decode(data)))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise DataError(f"a record of the run is not MessagePack: {error}") from error


def _event(document: dict[str, Any]) -> events.Event | None:
    kind = KINDS.get(str(document.get("event", "")))
    return None if kind is None else _convert(kind, document)


def truth_bytes(recording: str, truth: Mapping[str, float]) -> bytes:
    """Return the truth of a simulator for one recording."""
    return _json({"recording": recording, "truth": dict(truth)})


def truth_from(data: bytes) -> tuple[str, dict[str, float]]:
    """Return the recording's name and its truth."""
    document = _object(data)
    return _convert(str, document.get("recording")), _convert(
        dict[str, float], document.get("truth")
    )


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
    """Return the recording's name and the block; raise DataError."""
    try:
        (length,) = _LENGTH.unpack_from(data)
        start = _LENGTH.size + length
        head = _convert(_BlockHead, _object(data[_LENGTH.size : start]))
        shape = len(head.channels), head.samples
        table = np.frombuffer(data, "<f8", head.samples * len(head.channels), start).reshape(shape)
    except (struct.error, ValueError) as error:
        raise DataError(f"a block of samples is invalid: {error}") from error
    channels = dict(zip(head.channels, table, strict=True))
    return head.recording, Block(head.rate_hz, head.first_sample, head.monotonic_s, channels)


def _json(document: Mapping[str, Any]) -> bytes:
    return json.dumps(document).encode()


def _object(data: str | bytes) -> dict[str, Any]:
    """Return a JSON object; raise DataError. A checksum does not show who wrote it."""
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise DataError(f"a record of the run is not JSON: {error}") from error
    return document if isinstance(document, dict) else _convert(dict[str, Any], document)


def _convert(kind: type[_T], value: object) -> _T:
    """Return the value with the annotated types, without fields of a newer version.

    Raises DataError.
    """
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        raise DataError(f"a record of the run is invalid: {kind.__name__}: {error}") from error
