"""Samples out of a LabVIEW measurement file (.lvm), as they stand there."""

from __future__ import annotations

import re
from collections import deque
from dataclasses import dataclass, replace
from datetime import timedelta
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Column, DataError, Location, NotInFileError
from rigrunner_plugins.importers.cells import number
from rigrunner_plugins.importers.csv_file import encoding_of
from rigrunner_plugins.importers.finding import position
from rigrunner_plugins.importers.lvm_header import (
    content_lines,
    read_file_header,
    read_segment_header,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from datetime import datetime
    from pathlib import Path
    from typing import TextIO

    from rigrunner_plugins.importers.lvm_header import FileHeader, Line, SegmentHeader
    from rigrunner_plugins.importers.settings import LvmSettings


ALL = 1_000_000
"""More segments than a file has."""


def segment_range(group: str) -> range | None:
    """Return the numbers of the segments that a group names; None where it names none."""
    if not group:
        return None
    if group == "all":
        return range(1, ALL + 1)
    match = re.fullmatch(r"([1-9][0-9]{0,5})(?:-([1-9][0-9]{0,5}))?", group, re.ASCII)
    if match is None or int(match[2] or match[1]) < int(match[1]):
        hint = "such as 3, 1-20, or all"
        raise NotInFileError(f"'{group[:40]}' names no segments", hint=hint)
    return range(int(match[1]), int(match[2] or match[1]) + 1)


def join_segments(segments: Sequence[dict[str, Column]], place: Location) -> dict[str, Column]:
    """Return the columns of a recording that LabVIEW wrote as segments, and when each begins."""
    if len(segments) == 1:
        return segments[0]
    recording = {}
    for name, first in segments[0].items():
        columns = [segment[name] for segment in segments]
        for segment, column in enumerate(columns[1:], 2):
            if (column.unit, column.interval_s) != (first.unit, first.interval_s):
                what = f"segment {segment} of '{name}' has another unit or interval than the first"
                raise DataError(what, location=place)
        ends = np.cumsum([len(column.values) for column in columns])
        starts = [_start_of(name, column, place) for column in columns]
        recording[name] = replace(
            first,
            values=np.concatenate([column.values for column in columns]),
            goes=tuple(zip(ends[:-1].tolist(), starts[1:], strict=True)),
        )
    return recording


def _start_of(name: str, column: Column, place: Location) -> datetime:
    if column.started is None:
        raise DataError(
            f"'{name}' does not say when each segment began, so gaps cannot be detected",
            location=place,
            hint="take one segment, or write the recording in one piece",
        )
    return column.started + timedelta(seconds=column.offset_s)


_X = "X_Value"


@dataclass(frozen=True)
class LvmImporter:
    """Reads LVM files, in which a recording is a segment, or several that follow each other.

    The group is the number of the segment from 1, '2-30', or 'all'.
    """

    settings: LvmSettings

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return the wanted columns; see `rigrunner.api.importing.Importer`."""
        place = Location(str(path))
        try:
            with path.open(encoding=encoding_of(self.settings.encoding)) as file:
                return self._read(file, str(path), columns, segment_range(group))
        except UnicodeError as error:
            raise DataError(
                f"is not {self.settings.encoding}",
                location=place,
                hint="LabVIEW writes in the encoding of its machine: often encoding: latin-1",
            ) from error
        except OSError as error:
            raise DataError(f"cannot be read: {error.strerror or error}", location=place) from error

    def _read(
        self, file: TextIO, name: str, columns: Mapping[str, int | str], selection: range | None
    ) -> dict[str, Column]:
        lines = content_lines(file)
        header = read_file_header(lines, name, self.settings)
        parts: list[dict[str, Column]] = []
        count, segments = 0, _Segments(lines, name, header)
        for segment in segments:
            count += 1
            if count in (selection or (1,)):
                parts.append(_columns(segment, segments.rows(), name, header, columns))
        if not count:
            raise NotInFileError(
                "the file has no segment: it holds a header alone", location=Location(name)
            )
        last = selection and selection.stop - 1
        if (last is None and count > 1) or (last != ALL and (last or 1) > count) or not parts:
            raise NotInFileError(
                f"there is no segment {last}" if last else "no segment is named",
                location=Location(name),
                hint=f"there are {count}: give one as 'group', from 1 to {count}, or"
                " those that follow each other, such as 2-30, or all",
            )
        return join_segments(parts, Location(name))


class _Segments:
    """The segments of a file, one after the other: each header, and then its rows."""

    def __init__(self, lines: Iterator[Line], file: str, header: FileHeader) -> None:
        self._lines = lines
        self._file = file
        self._header = header
        self._next: Line | None = None

    def __iter__(self) -> Iterator[SegmentHeader]:
        """Yield each header; rows that were not read are skipped."""
        while first := self._next or next(self._lines, None):
            self._next = None
            yield read_segment_header(first, self._lines, self._file, self._header)
            if self._next is None:
                deque(self.rows(), maxlen=0)

    def rows(self) -> Iterator[Line]:
        """Yield the lines of the segment up to the next header."""
        for line in self._lines:
            if line[1][:1].isalpha():
                self._next = line
                return
            yield line


def _columns(
    segment: SegmentHeader,
    rows: Iterable[Line],
    file: str,
    header: FileHeader,
    columns: Mapping[str, int | str],
) -> dict[str, Column]:
    place = Location(file, segment.line)
    index_of = {
        wanted: position(wanted, column, segment.names, place) for wanted, column in columns.items()
    }
    cells = _cells(rows, file, header, segment, list(index_of.values()))
    timed = any(segment.names[index] == _X for index in index_of.values())
    result = {}
    for (wanted, index), values in zip(index_of.items(), cells, strict=True):
        name, stated = segment.names[index], segment.samples(index)
        if stated is not None and (len(values) < stated or (len(values) > stated and not timed)):
            raise DataError(
                f"the column '{name}' has {len(values)} samples, its header says {stated}",
                location=place,
                hint="is the file cut short?"
                if len(values) < stated
                else "it was written in several parts; gaps can be detected only in X values: use"
                " their column as the time",
            )
        if not values:
            raise DataError(f"the column '{name}' is empty", location=place)
        interval_s, within_s = segment.interval(index, header.decimal)
        result[wanted] = Column(
            np.array(values),
            unit=segment.of("Y_Unit_Label", index),
            interval_s=interval_s,
            interval_within_s=within_s,
            started=segment.start_time(index),
            offset_s=number(segment.of("X0", index), header.decimal) or 0.0,
        )
    return result


def _cells(
    rows: Iterable[Line], file: str, header: FileHeader, segment: SegmentHeader, indices: list[int]
) -> list[list[float]]:
    """Return the numbers of the wanted columns; a column that has ended may not continue."""
    columns: list[list[float]] = [[] for _ in indices]
    ended = [False] * len(indices)
    for line, text in rows:
        cells = text.split(header.separator)
        for place, index in enumerate(indices):
            cell = cells[index] if index < len(cells) else ""
            if not cell.strip():
                ended[place] = True
                continue
            value = None if ended[place] else number(cell, header.decimal)
            if value is None:
                problem = (
                    f"'{segment.names[index]}' continues after an empty cell"
                    if ended[place]
                    else f"'{cell[:40]}' is not a number with '{header.decimal}' as decimal mark"
                )
                raise DataError(problem, location=Location(file, line))
            columns[place].append(value)
    return columns
