"""One recording of another program, in SI units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, InvalidFileError, Location, Problem
from rigrunner.api.importing import NotInFileError
from rigrunner.api.quantity import QuantityError, unit
from rigrunner.workflow.importing.sampling import rate_of, start_of
from rigrunner.yamlfile.document import dotted

if TYPE_CHECKING:
    from collections.abc import Mapping
    from datetime import datetime

    from rigrunner.api.data import Array
    from rigrunner.api.importing import Column, Importer
    from rigrunner.workflow.importing.mapping import ColumnSpec, LoadedMapping, Part, TimeSpec
    from rigrunner.yamlfile.document import Path as DocumentPath

_TIME = "time"
_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Wanted:
    """A column of a recording, and where the mapping asks for it."""

    spec: ColumnSpec | TimeSpec
    at: DocumentPath


@dataclass(frozen=True, eq=False)
class Read:
    """What a file gives of a recording: columns of shape (n,), in SI units."""

    rate_hz: float
    columns: Mapping[str, Array]
    started: datetime | None
    """When its first sample was taken, if the file says so; local time has no zone."""


def read_part(
    mapping: LoadedMapping,
    importer: Importer,
    part: Part,
    at: DocumentPath,
    wanted: Mapping[str, Wanted],
) -> Read:
    """Read the wanted columns of a recording, which stands in the mapping at `at`.

    Raises InvalidFileError where the mapping and the file contradict each other, and DataError
    where the file is not a recording without gaps.
    """
    sampling = mapping.model.sampling
    asked = dict(wanted)
    if sampling.time is not None:
        asked[_TIME] = Wanted(sampling.time, ("sampling", "time"))
    found = _columns(mapping, importer, part, at, asked)
    file = str(mapping.file(part.file))
    _check_lengths(found, asked, file)
    in_si = {name: _in_si(mapping, column, asked[name], file) for name, column in found.items()}
    times_s = in_si.pop(_TIME, None)
    sampled = {name: found[name] for name in wanted}
    rate_hz = rate_of(sampled, times_s, sampling.rate, file)
    first, last = _window(mapping, part, at, rate_hz, len(next(iter(in_si.values()))))
    started = start_of(sampled, rate_hz, file)
    return Read(rate_hz, {name: values[first:last] for name, values in in_si.items()}, started)


def _columns(
    mapping: LoadedMapping,
    importer: Importer,
    part: Part,
    at: DocumentPath,
    asked: Mapping[str, Wanted],
) -> Mapping[str, Column]:
    names = {name: each.spec.column for name, each in asked.items()}
    try:
        return importer.read(mapping.file(part.file), names, part.group)
    except NotInFileError as error:
        known = error.wanted in asked
        path = (*asked[error.wanted].at, "column") if known else (*at, "group")
        place = error.location or Location(str(mapping.file(part.file)))
        raise fault(mapping, path, f"{place}: {error.message}", error.hint) from error


def fault(
    mapping: LoadedMapping, path: DocumentPath, message: str, hint: str = ""
) -> InvalidFileError:
    """Return an error at a place in the mapping."""
    return InvalidFileError([Problem(message, mapping.document.where(path), dotted(path), hint)])


def _check_lengths(found: Mapping[str, Column], asked: Mapping[str, Wanted], file: str) -> None:
    lengths = {name: len(column.values) for name, column in found.items()}
    if len(set(lengths.values())) > 1:
        counts = (f"{count} of '{asked[name].spec.column}'" for name, count in lengths.items())
        told = ", ".join(counts)
        raise DataError(
            f"the columns have different numbers of samples: {told}", location=Location(file)
        )


def _in_si(mapping: LoadedMapping, column: Column, wanted: Wanted, file: str) -> Array:
    spec = wanted.spec
    if column.unit and not _agrees(column.unit, spec):
        raise fault(
            mapping,
            (*wanted.at, "unit"),
            f"{file} states '{column.unit[:40]}' for '{spec.column}', not '{spec.unit}'",
            "correct the unit; or, where the file is known to be wrong, say so:"
            f" file_says: {column.unit[:40]}",
        )
    known = unit(spec.unit)
    return column.values * known.factor + known.offset


def _agrees(stated: str, spec: ColumnSpec | TimeSpec) -> bool:
    if stated == spec.file_says:
        return True
    try:
        return unit(stated).symbol == spec.unit
    except QuantityError:
        return False


def _window(
    mapping: LoadedMapping, part: Part, at: DocumentPath, rate_hz: float, samples: int
) -> tuple[int, int]:
    """Return the first sample that belongs to the recording, and the one after the last."""
    length_s = samples / rate_hz
    for key, seconds in (("from", part.from_), ("to", part.to)):
        if seconds is not None and seconds > length_s * (1 + _TOLERANCE):
            message = f"{part.file} is only {length_s:.6g} s long"
            raise fault(mapping, (*at, key), message)
    first = 0 if part.from_ is None else round(part.from_ * rate_hz)
    last = samples if part.to is None else min(round(part.to * rate_hz), samples)
    if first >= last:
        raise fault(mapping, at, "no sample lies between 'from' and 'to'")
    return first, last
