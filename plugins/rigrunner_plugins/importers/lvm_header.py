"""Headers of LVM files: National Instruments, Specification for the LabVIEW Measurement File.

https://www.ni.com/en/support/documentation/supplemental/06/specification-for-the-labview-measurement-file---lvm-.html
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

from rigrunner.api import DataError, Location
from rigrunner_plugins.importers.cells import number

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner_plugins.importers.settings import LvmSettings

FIRST = "LabVIEW Measurement"
END = "***End_of_Header***"
SPECIAL, END_SPECIAL = "***Start_Special***", "***End_Special***"
_SEPARATORS = {"Tab": "\t", "Comma": ","}
_MOST_LINES = 1000
"""No header is as long; a file without its end is found out before all of it is read."""
_MOST_DECIMALS_OF_S = 6

Line = tuple[int, str]
"""The number of a line, from 1, and its text."""


@dataclass(frozen=True)
class FileHeader:
    """How the segments of a file are written."""

    separator: str
    decimal: str


@dataclass(frozen=True)
class SegmentHeader:
    """The header of a segment: the cells of each tag's line, and the names of the columns."""

    line: int
    tags: Mapping[str, Sequence[str]]
    names: Sequence[str]
    """Of all columns but the comments, those of X values included."""

    def of(self, tag: str, column: int) -> str:
        """Return the value of a tag for a column; '' if there is none."""
        cells = self.tags.get(tag, ())
        return cells[column].strip() if column < len(cells) else ""

    def start_time(self, column: int) -> datetime | None:
        """Return when the column's first sample was taken, in local time."""
        day = self.of("Date", column)
        time, _, decimals = self.of("Time", column).replace(",", ".").partition(".")
        fraction = decimals[:_MOST_DECIMALS_OF_S].ljust(_MOST_DECIMALS_OF_S, "0")
        try:
            return datetime.strptime(f"{day} {time}.{fraction}", "%Y/%m/%d %H:%M:%S.%f")  # noqa: DTZ007  (the file does not say in which zone)
        except ValueError:
            return None

    def interval(self, column: int, decimal: str) -> tuple[float | None, float]:
        """Return the interval in s and how far its digits let it be from the true one."""
        text = self.of("Delta_X", column)
        seconds = number(text, decimal)
        if self.of("X_Dimension", column) not in {"Time", ""} or not seconds or seconds < 0:
            return None, 0.0
        # What was rounded is off by half of its last digit at most.
        match = re.fullmatch(r"\s*[0-9]*(?:[.,]([0-9]*))?(?:[eE]([+-]?[0-9]{1,3}))?\s*", text)
        if match is None:
            return seconds, 0.0
        return seconds, 0.5 * 10.0 ** (int(match[2] or 0) - len(match[1] or ""))

    def samples(self, column: int) -> int | None:
        """Return the number of samples of the column by the header."""
        text = self.of("Samples", column)
        return int(text) if text.isascii() and text.isdigit() else None


def content_lines(file: Iterable[str]) -> Iterator[Line]:
    """Yield the lines with content: blank ones and special blocks are skipped."""
    special = False
    for number_, line in enumerate(file, 1):
        text = line.rstrip("\r\n")
        if text.startswith((SPECIAL, END_SPECIAL)):
            special = text.startswith(SPECIAL)
        elif not special and text.strip():
            yield number_, text


def read_file_header(lines: Iterator[Line], file: str, settings: LvmSettings) -> FileHeader:
    """Return the header of a file; raise DataError naming the line."""
    number_, first = next(lines, (1, ""))
    if not first.startswith(FIRST):
        raise DataError(
            f"is not an LVM file with a header: '{FIRST}' is not first",
            location=Location(file, number_),
            hint="one that was written without headers can be read as CSV",
        )
    separator, tags = "\t", {}
    for _, text in _until_end(lines, file, "of the file"):
        if text.startswith("Separator") and text[9:10]:
            # As the tag says, or else what follows the tag itself.
            separator = _SEPARATORS.get(text[10:].strip(" \t,;"), text[9])
        tag, *values = [cell.strip() for cell in text.split(separator)]
        tags[tag] = values[0] if values else ""
    decimal = tags.get("Decimal_Separator")
    if not decimal:  # it is not stated, or is a comma that separates and so ended its own cell
        decimal = "." if separator == "," and decimal is None else settings.decimal
    if decimal not in {".", ","} or decimal == separator:
        raise DataError(
            f"the decimal mark '{decimal}' is the separator, or not a decimal mark",
            location=Location(file),
        )
    return FileHeader(separator, decimal)


def read_segment_header(
    first: Line, lines: Iterator[Line], file: str, header: FileHeader
) -> SegmentHeader:
    """Return the header of a segment that begins with that line, and the names of its columns."""
    tags: dict[str, list[str]] = {}
    for text in (first[1], *(text for _, text in _until_end(lines, file, "of a segment"))):
        cells = text.split(header.separator)
        tags[cells[0].strip()] = cells
    line, text = next(lines, (first[0], ""))
    names = [cell.strip() for cell in text.split(header.separator)]
    if names[:1] != ["X_Value"]:
        raise DataError(
            "the names of the columns are not there: 'X_Value' is not first",
            location=Location(file, line),
            hint="is the file cut short?",
        )
    while names[-1] in {"", "Comment"} and len(names) > 1:
        names.pop()
    return SegmentHeader(line, tags, names)


def _until_end(lines: Iterator[Line], file: str, what: str) -> Iterator[Line]:
    """Yield the lines of a header."""
    line = 0
    for count, (line, text) in enumerate(lines):
        if text.startswith(END):
            return
        if count > _MOST_LINES:
            break
        yield line, text
    raise DataError(
        f"the header {what} has no end: '{END}' is missing",
        location=Location(file, line or None),
        hint="is the file cut short?",
    )
