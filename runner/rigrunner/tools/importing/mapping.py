"""The file that maps recordings of another program to the channels of a station."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from datetime import datetime
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    WithJsonSchema,
    model_validator,
)

from rigrunner.api.member import Member
from rigrunner.api.names import Name, Text
from rigrunner.api.plugin_refs import PluginRef
from rigrunner.api.settings import AnyQuantity, Duration, Frequency, ListOf, Settings, UnitSymbol
from rigrunner.api.units import QuantityError, unit, units_of
from rigrunner.yamlfile import parse, validate
from rigrunner.yamlfile.reader import read_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.quantity import Quantity
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path as DocumentPath

IMPORTER = "importer"


def _time_unit(symbol: str) -> str:
    parsed = unit(symbol)
    if parsed.dimension != "time":
        hint = f"units of time: {', '.join(units_of('time'))}"
        raise QuantityError(f"'{symbol}' is a unit of {parsed.dimension}, not of time", hint=hint)
    return parsed.symbol


def _moment(value: object) -> object:
    if not isinstance(value, str):
        return value
    try:
        moment = datetime.fromisoformat(value)
    except ValueError:
        moment = None
    if moment is None or moment.tzinfo is None:
        raise ValueError(
            f"'{value[:40]}' is not a time with its zone; write it as 2026-01-31T09:15:00+01:00"
        )
    return moment


def _kind(value: object) -> str:
    if isinstance(value, list | tuple):
        return "list"
    return "column" if isinstance(value, dict | Settings) else "quantity"


Moment = Annotated[
    datetime,
    BeforeValidator(_moment),
    WithJsonSchema(
        {
            "type": "string",
            "pattern": r"^\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d+)?)?(Z|[+-]\d\d:\d\d)$",
            "errorMessage": "expected a time with its zone, such as 2026-01-31T09:15:00+01:00",
        }
    ),
]
ColumnName = Annotated[int, Field(ge=1)] | Text


class ImporterRef(PluginRef):
    """The format of the files: an importer by its name, or as `name: {setting: value}`."""

    kind = IMPORTER


class ColumnSpec(Settings):
    """The column with the values of a channel, and their unit."""

    column: ColumnName
    """Its name in the file (of a table also its number, from 1)."""
    unit: UnitSymbol
    """The unit of the numbers in the file."""
    file_says: Text | None = None
    """The unit that the file states, if it is known to be wrong."""


class TimeSpec(Settings):
    """The column with the times of the samples."""

    column: ColumnName
    """Its name in the file, or its number from 1."""
    unit: Annotated[str, AfterValidator(_time_unit)]
    """The unit of the times in the file."""
    file_says: Text | None = None
    """The unit that the file states, if it is known to be wrong."""


class Sampling(Settings):
    """The sampling rate. What the files state need not be repeated."""

    rate: Annotated[Frequency | None, Field(gt=0)] = None
    """Samples per second and channel."""
    time: TimeSpec | None = None
    """The times of the samples; all intervals must be equal."""


class Part(Settings):
    """A recording: a file, or a part of it."""

    file: Text
    """Its path, relative to the mapping's folder."""
    group: str = ""
    """The part of the file: a group, a structure, or the number of a segment."""
    from_: Annotated[Duration | None, Field(alias="from", ge=0)] = None
    """Start of the recording, counted from the first sample."""
    to: Annotated[Duration | None, Field(gt=0)] = None
    """End of the recording, counted from the first sample."""

    def overlaps(self, other: Part) -> bool:
        """Return whether both have samples in common."""
        return (self.file, self.group) == (other.file, other.group) and max(
            self.from_ or 0.0, other.from_ or 0.0
        ) < min(self.to or inf, other.to or inf)

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        if self.from_ is not None and self.to is not None and self.from_ >= self.to:
            raise ValueError("'from' must be before 'to'")
        return self


Condition = Annotated[
    Annotated[AnyQuantity, Tag("quantity")] | Annotated[ColumnSpec, Tag("column")],
    Discriminator(_kind),
]
"""A value, or the column whose mean is used."""
ZeroSpec = Annotated[
    Annotated[AnyQuantity, Tag("quantity")] | Annotated[Part, Tag("column")],
    Discriminator(_kind),
]
"""The reading at rest, or a recording at rest whose mean is used."""
ZeroSpecs = Annotated[
    Annotated[AnyQuantity, Tag("quantity")]
    | Annotated[Part, Tag("column")]
    | Annotated[ListOf[ZeroSpec], Field(min_length=1), Tag("list")],
    Discriminator(_kind),
]
"""One, or for a channel that is zeroed several times one for each, in their order."""


class RecordingEntry(Part):
    """A recording and the set-points at which it was made."""

    set_points: dict[Member, AnyQuantity] = Field(default_factory=dict)
    """Set-points, by role.drive, in addition to those for all recordings."""
    conditions: dict[Member, Condition] = Field(default_factory=dict)
    """Further values measured during the recording, by role.channel."""


class MeasurementEntry(Settings):
    """Single values that were read: a row of a table."""

    name: Text
    """The name of the table, as in the step that measures."""
    values: Annotated[dict[Member, AnyQuantity], Field(min_length=1)]
    """The values, by role.channel."""


class ImportMapping(Settings):
    """Recordings of another program as a run of a procedure on a station."""

    rigrunner: Literal["import/1"]
    """The kind of file, and the version of its language."""
    procedure: Text
    """The procedure that was used: a file beside this one, or the name of a shipped one."""
    station: Text
    """The rig that was used: a file beside this one, or the name of a shipped one."""
    format: ImporterRef
    program: Text
    """The program that made the recordings, with its version."""
    by: Text
    """Who is responsible for the content of this file."""
    started: Moment
    """When the run began."""
    ended: Moment | None = None
    """When it ended; by default, with the last recording."""
    inputs: dict[Name, Text] = Field(default_factory=dict)
    """Answers to the inputs of the procedure."""
    sampling: Sampling = Field(default_factory=Sampling)
    channels: Annotated[dict[Member, ColumnSpec], Field(min_length=1)]
    """The columns of each channel, by role.channel."""
    zeros: dict[Member, ZeroSpecs] = Field(default_factory=dict)
    """The reading of each channel at rest, if the procedure zeroes it; a list for several times."""
    set_points: dict[Member, AnyQuantity] = Field(default_factory=dict)
    """Set-points of all recordings, by role.drive."""
    conditions: dict[Member, Condition] = Field(default_factory=dict)
    """Further values measured during all recordings, by role.channel."""
    measurements: ListOf[MeasurementEntry] = ()
    """Results of the steps that measure, in the order of the procedure."""
    recordings: Annotated[ListOf[RecordingEntry], Field(min_length=1)]
    """Each recording of the procedure, in the order in which they were made."""

    def zeros_of(self, member: Member) -> tuple[tuple[DocumentPath, Quantity | Part], ...]:
        """Return the readings of a channel at rest with their places, one for each zero."""
        zeros, place = self.zeros[member], ("zeros", member)
        if not isinstance(zeros, tuple):
            return ((place, zeros),)
        return tuple(((*place, index), zero) for index, zero in enumerate(zeros))

    def parts(self) -> Iterator[tuple[DocumentPath, Part]]:
        """Yield each recording, also those at rest, with its place in the mapping."""
        for index, entry in enumerate(self.recordings):
            yield ("recordings", index), entry
        for member in self.zeros:
            for place, zero in self.zeros_of(member):
                if isinstance(zero, Part):
                    yield place, zero

    @model_validator(mode="after")
    def _check_times(self) -> Self:
        if self.ended is not None and self.ended < self.started:
            raise ValueError("the run ended before it was started")
        return self


@dataclass(frozen=True, eq=False)
class LoadedMapping:
    """A mapping, the place of each part, and its text."""

    model: ImportMapping
    document: Document
    text: str

    @property
    def path(self) -> Path:
        """The file."""
        return Path(self.document.name)

    @property
    def digest(self) -> str:
        """SHA-256 of the text in UTF-8, hexadecimal."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    def file(self, name: str) -> Path:
        """Return the path of a file that it names."""
        return self.path.parent / name


def load_mapping(path: Path) -> LoadedMapping:
    """Return the mapping in that file; raise InvalidFileError with all problems."""
    text = read_text(path)
    document = parse(text, str(path))
    return LoadedMapping(validate(ImportMapping, document), document, text)
