"""Headers, events and sample blocks as bytes, and back."""

from __future__ import annotations

import json
import struct
from dataclasses import asdict, dataclass, is_dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError
from pydantic_core import PydanticSerializationError, SchemaSerializer, from_json, to_json

from rigrunner.api import events
from rigrunner.api.data import Block
from rigrunner.api.errors import DataError
from rigrunner.runfile.model import FORMAT, RunHeader

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from pydantic.plugin._schema_validator import PluggableSchemaValidator
    from pydantic_core import SchemaValidator

_T = TypeVar("_T")
_LENGTH = struct.Struct("<I")
_KINDS: Mapping[str, type[events.Event]] = {
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


@dataclass(frozen=True, kw_only=True)
class _BlockHead:
    """What stands before the samples of a block."""

    recording: str
    rate_hz: Annotated[float, Field(gt=0)]
    first_sample: int
    monotonic_s: float
    samples: Annotated[int, Field(ge=0)]
    channels: tuple[str, ...]


def header_bytes(header: RunHeader) -> bytes:
    """Return a header as JSON with the format's version."""
    return _json({"format": FORMAT, **asdict(header)})


def header_from(data: bytes, source: str) -> tuple[RunHeader, int]:
    """Return the header and the format's version; raise DataError if a newer version wrote it."""
    document = _object(data)
    version = document.pop("format", None)
    if not isinstance(version, int):
        raise DataError(f"{source} does not say in which format it is")
    check_format(version, source)
    return _checked(RunHeader, document), version


def check_format(version: int, source: str) -> None:
    """Raise DataError if `source` was written in a format that is newer than this program."""
    if version > FORMAT:
        raise DataError(
            f"{source} was written by a newer version of Rigrunner"
            f" (format {version}, this one reads up to {FORMAT})",
            hint="read it with that version",
        )


def event_bytes(event: events.Event) -> bytes:
    """Return an event as JSON. The truth of a simulator is left out: it is kept apart."""
    opening, encode = _encoder(type(event))  # type: ignore[arg-type]  # mypy: no type is hashable
    try:  # in half the time of an encoder that does not know the kinds of its fields
        return opening + encode(event, warnings=False)[1:]
    except PydanticSerializationError:  # a mapping that is no dict, half of a surrogate pair
        return plain_event_bytes(event)


def plain_event_bytes(event: events.Event) -> bytes:
    """Return the same, whatever its fields hold."""
    return json.dumps(_document(event), default=_plain).encode()


def event_text(event: events.Event) -> str:
    """Return the same as text that is ASCII alone."""
    try:
        return to_json(_document(event), ensure_ascii=True, fallback=dict).decode()
    except PydanticSerializationError:
        return plain_event_bytes(event).decode()


def _plain(value: Any) -> dict[str, Any]:
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else dict(value)


def _document(event: events.Event) -> dict[str, Any]:
    document = {"event": type(event).__name__, **vars(event)}
    document.pop("truth", None)
    return document


def event_from(text: str | bytes) -> events.Event | None:
    """Return the event; None for a kind that this version does not know."""
    document = _object(text)
    kind = _KINDS.get(str(document.pop("event", "")))
    return None if kind is None else _checked(kind, document)


def truth_bytes(recording: str, truth: Mapping[str, float]) -> bytes:
    """Return what a simulator knows of one recording."""
    return _json({"recording": recording, "truth": dict(truth)})


def truth_from(data: bytes) -> tuple[str, dict[str, float]]:
    """Return the recording's name and its truth."""
    document = _object(data)
    return _checked(str, document.get("recording")), _checked(
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
        head = _checked(_BlockHead, _object(data[_LENGTH.size : start]))
        shape = len(head.channels), head.samples
        table = np.frombuffer(data, "<f8", head.samples * len(head.channels), start).reshape(shape)
    except (struct.error, ValueError) as error:
        raise DataError(f"a block of samples is not what it should be: {error}") from error
    channels = dict(zip(head.channels, table, strict=True))
    return head.recording, Block(head.rate_hz, head.first_sample, head.monotonic_s, channels)


def _json(document: Mapping[str, Any]) -> bytes:
    return json.dumps(document).encode()


def _object(data: str | bytes) -> dict[str, Any]:
    """Return a JSON object; raise DataError: a checksum says that it was written, not by whom."""
    document = _parsed(data)
    return document if isinstance(document, dict) else _checked(dict[str, Any], document)


def _parsed(data: str | bytes) -> object:
    try:  # the same as json.loads in half of its time, but for half of a surrogate pair
        return from_json(data)
    except ValueError:
        pass
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise DataError(f"a record of the run is not JSON: {error}") from error


def _checked(kind: type[_T], value: object) -> _T:
    """Return the value as the annotations have it, without fields of a newer version.

    Raise DataError.
    """
    try:
        checked: _T = _validator(cast("Any", kind)).validate_python(value)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise DataError(
            f"a record of the run is not what it should be: {kind.__name__} {where}".rstrip(),
            hint=str(first["msg"]),
        ) from error
    return checked


@cache
def _encoder(kind: Any) -> tuple[bytes, Callable[..., bytes]]:
    """Return how an event of that kind begins, and what encodes it with its opening brace.

    A name in a mapping may be anything: of one that is said to be a text it would replace what is
    half of a surrogate pair.
    """
    schema = cast("Any", TypeAdapter(kind).core_schema)
    _keep_constants(schema)
    for each in schema["schema"]["fields"]:
        each["serialization_exclude"] = each["name"] == "truth"
        values = each["schema"].get("schema", each["schema"])
        if values["type"] == "dict":
            values["keys_schema"] = {"type": "any"}
    return f'{{"event":"{kind.__name__}",'.encode(), SchemaSerializer(schema).to_json


def _keep_constants(schema: object) -> None:
    """Let a schema, and those of the dataclasses in it, write infinity and NaN as they are."""
    if isinstance(schema, dict):
        if schema.get("type") == "dataclass":
            schema["config"] = {"ser_json_inf_nan": "constants"}
        for each in schema.values():
            _keep_constants(each)
    elif isinstance(schema, list):
        for each in schema:
            _keep_constants(each)


@cache
def _validator(kind: Any) -> SchemaValidator | PluggableSchemaValidator:
    return TypeAdapter(kind).validator
