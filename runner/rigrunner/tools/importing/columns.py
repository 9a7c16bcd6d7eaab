"""Read one recording of another program, in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError, InvalidFileError, Location, PluginError, Problem
from rigrunner.api.importing import Column, NotInFileError
from rigrunner.api.samples import as_samples
from rigrunner.api.units import find_unit, unit
from rigrunner.tools.importing.sampling import rate_of, start_of
from rigrunner.yamlfile.document import dotted

if TYPE_CHECKING:
    from datetime import datetime

    from rigrunner.api.data import Array
    from rigrunner.api.importing import Importer
    from rigrunner.tools.importing.mapping import ColumnSpec, LoadedMapping, Part, TimeSpec
    from rigrunner.yamlfile.document import Path as DocumentPath

_TIME = "time"
_TOLERANCE = 1e-6


@dataclass(frozen=True)
class MappedColumn:
    """A column of a recording, and where the mapping names it."""

    spec: ColumnSpec | TimeSpec
    at: DocumentPath


@dataclass(frozen=True, eq=False)
class RecordingData:
    """The content of a file for one recording: columns of shape (n,), in SI units."""

    rate_hz: float
    columns: Mapping[str, Array]
    started: datetime | None
    """When its first sample was taken, if the file has it; local time has no zone."""


def read_part(
    mapping: LoadedMapping,
    importer: Importer,
    part: Part,
    at: DocumentPath,
    mapped: Mapping[str, MappedColumn],
) -> RecordingData:
    """Read the mapped columns of a recording, whose entry in the mapping is at `at`.

    Raises InvalidFileError if the mapping and the file contradict each other, and DataError if the
    file is not a recording without gaps.
    """
    sampling = mapping.model.sampling
    requested = dict(mapped)
    if sampling.time is not None:
        requested[_TIME] = MappedColumn(sampling.time, ("sampling", "time"))
    columns = _columns(mapping, importer, part, at, requested)
    file = str(mapping.file(part.file))
    lengths = {name: len(column.values) for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        counts = (f"{count} of '{requested[name].spec.column}'" for name, count in lengths.items())
        message = f"the columns have different numbers of samples: {', '.join(counts)}"
        raise DataError(message, location=Location(file))
    in_si = {name: _in_si(mapping, columns[name], requested[name], file) for name in columns}
    times_s = in_si.pop(_TIME, None)
    sampled = {name: columns[name] for name in mapped}
    rate_hz = rate_of(sampled, times_s, sampling.rate, file)
    first, last = _window(mapping, part, at, rate_hz, len(next(iter(in_si.values()))))
    started = start_of(sampled, rate_hz, file)
    in_window = {name: values[first:last] for name, values in in_si.items()}
    return RecordingData(rate_hz, in_window, started)


def _columns(
    mapping: LoadedMapping,
    importer: Importer,
    part: Part,
    at: DocumentPath,
    requested: Mapping[str, MappedColumn],
) -> Mapping[str, Column]:
    names = {name: column.spec.column for name, column in requested.items()}
    try:
        columns = importer.read(mapping.file(part.file), names, part.group)
    except NotInFileError as error:
        is_column = error.wanted in requested
        path = (*requested[error.wanted].at, "column") if is_column else (*at, "group")
        place = error.location or Location(str(mapping.file(part.file)))
        raise fault(mapping, path, f"{place}: {error.message}", error.hint) from error
    if not isinstance(columns, Mapping):
        raise _importer_error(mapping, f"{type(columns).__name__}, expected a Column for each name")
    return {name: _checked_column(mapping, name, columns.get(name)) for name in requested}


def _checked_column(mapping: LoadedMapping, name: str, column: object) -> Column:
    """Return a column of the shape and type that importers must give; raise PluginError."""
    if not isinstance(column, Column):
        raise _importer_error(mapping, f"{column!r} for '{name}', expected a Column")
    try:
        values = as_samples(column.values)
    except TypeError as error:
        problem = f"values that are {error} for '{name}', not float64"
        raise _importer_error(mapping, problem) from error
    if values.ndim != 1 or not np.isfinite(values).all():
        raise _importer_error(mapping, f"values for '{name}' that are not a row of finite numbers")
    interval_s = column.interval_s
    is_time = isinstance(interval_s, Real) and isfinite(interval_s) and interval_s > 0
    if interval_s is not None and not is_time:
        raise _importer_error(mapping, f"an interval of {interval_s!r} s for '{name}'")
    return replace(column, values=values)


def _importer_error(mapping: LoadedMapping, what: str) -> PluginError:
    name = mapping.model.format.name
    hint = f"report it to its author; see 'rigrunner check-plugin {name}'"
    return PluginError(f"the importer '{name}' gave {what}", hint=hint)


def fault(
    mapping: LoadedMapping, path: DocumentPath, message: str, hint: str = ""
) -> InvalidFileError:
    """Return an error at a place in the mapping."""
    return InvalidFileError([Problem(message, mapping.document.where(path), dotted(path), hint)])


def _in_si(mapping: LoadedMapping, column: Column, mapped: MappedColumn, file: str) -> Array:
    spec = mapped.spec
    file_unit = find_unit(column.unit)
    agrees = column.unit in {"", spec.file_says} or (file_unit and file_unit.symbol == spec.unit)
    if not agrees:
        raise fault(
            mapping,
            (*mapped.at, "unit"),
            f"{file} states '{column.unit[:40]}' for '{spec.column}', not '{spec.unit}'",
            "correct the unit; or, where the file is known to be wrong, say so:"
            f" file_says: {column.unit[:40]}",
        )
    return unit(spec.unit).to_si(column.values)


def _window(
    mapping: LoadedMapping, part: Part, at: DocumentPath, rate_hz: float, samples: int
) -> tuple[int, int]:
    """Return the first sample of the recording, and the one after its last."""
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
