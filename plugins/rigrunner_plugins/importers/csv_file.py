"""Samples out of a CSV file, as they stand there: no unit is converted here."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Column, DataError, Location, NotInFileError, find_unit
from rigrunner_plugins.importers.cells import number
from rigrunner_plugins.importers.finding import position

if TYPE_CHECKING:
    from _csv import Reader
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner_plugins.importers.settings import TableSettings

_UNITS = (re.compile(r"\s/\s+(\S.*)$"), re.compile(r"[(\[]([^()\[\]]+)[)\]]\s*$"))
"""Where a name states its unit: 'T / mN·m' (ISO 80000-1, 7.1.4), 'T (mN·m)', 'T [mN·m]'."""


@dataclass(frozen=True)
class CsvImporter:
    """Reads CSV files, each of which holds one recording."""

    table: TableSettings

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return the wanted columns; see `rigrunner.api.importing.Importer`."""
        if group:
            raise NotInFileError(f"a CSV file has no groups, but '{group}' is asked for")
        return read_csv(path, columns, self.table)


def read_csv(
    path: Path, columns: Mapping[str, int | str], table: TableSettings
) -> dict[str, Column]:
    """Return each wanted column, by its name or its number from 1.

    A unit is what stands in brackets, or behind ' / ', at the end of a column's name, where that is
    one. Raises DataError naming file and line.
    """
    delimiter = "\t" if table.delimiter == "tab" else table.delimiter
    try:
        with path.open(newline="", encoding=encoding_of(table.encoding)) as file:
            for _ in range(table.skip_lines):
                next(file, "")
            reader = csv.reader(file, delimiter=delimiter)
            header = [name.strip() for name in next(reader, [])] if table.header else []
            index_of = _find(columns, header, path, table)
            rows = _rows(reader, list(index_of.values()), len(header), path, table)
            samples = np.array(list(rows), dtype=np.float64).reshape(-1, len(index_of))
    except UnicodeError as error:
        raise DataError(f"is not {table.encoding}", location=Location(str(path))) from error
    except csv.Error as error:
        raise DataError(f"is not CSV: {error}", location=Location(str(path))) from error
    except OSError as error:
        raise DataError(
            f"cannot be read: {error.strerror or error}", location=Location(str(path))
        ) from error
    if not len(samples):
        raise DataError("has no row of numbers", location=Location(str(path)))
    return {
        name: Column(samples[:, place], _unit(header[index]) if header else "")
        for place, (name, index) in enumerate(index_of.items())
    }


def encoding_of(name: str) -> str:
    """Return an encoding that takes a byte order mark where there may be one."""
    return "utf-8-sig" if name == "utf-8" else name


def _unit(name: str) -> str:
    """Return the unit at the end of a column's name; '' where none is stated."""
    units = [match[1].strip() for pattern in _UNITS if (match := pattern.search(name))]
    return next((unit for unit in units if find_unit(unit)), "")


def _find(
    columns: Mapping[str, int | str], header: Sequence[str], path: Path, table: TableSettings
) -> Mapping[str, int]:
    """Return the index of each wanted column; without a header, numbers alone are known."""
    place = Location(str(path), table.skip_lines + 1)
    index_of = {}
    for wanted, column in columns.items():
        if table.header:
            index_of[wanted] = position(wanted, column, header, place)
        elif isinstance(column, int):
            index_of[wanted] = column - 1
        else:
            raise NotInFileError(
                f"the column '{column}' of '{wanted}' is not there: the file names no columns",
                wanted=wanted,
                location=place,
                hint="give its number instead",
            )
    return index_of


def _rows(
    reader: Reader, indices: list[int], width: int, path: Path, table: TableSettings
) -> Iterator[list[float]]:
    """Yield the wanted numbers of each row; `width` is how many names there are, or 0."""
    # Without names the number of columns is not known: all rows may be split alike.
    expected = width or table.columns or max(indices) + 1
    for row in reader:
        if not row:
            continue
        line = table.skip_lines + reader.line_num  # a quoted cell may take several lines
        if len(row) <= max(indices):
            raise DataError(
                f"has {len(row)} columns, {max(indices) + 1} are needed",
                location=Location(str(path), line),
                hint=f"the delimiter is set to '{table.delimiter}'",
            )
        # In '0,1,234.5' the second number would be 1.
        if any(cell.strip() for cell in row[expected:]):
            hint = f"'{table.delimiter}' is set as delimiter: does it also mark decimals or"
            hint += " thousands?"
            if not (table.header or table.columns):
                hint += f" if not, state 'columns: {len(row)}' in the settings"
            raise DataError(
                f"has {len(row)} columns, {'the header has' if table.header else 'expected'}"
                f" {expected}",
                location=Location(str(path), line),
                hint=hint,
            )
        numbers = []
        for index in indices:
            value = number(row[index], table.decimal)
            if value is None:
                raise DataError(
                    f"'{row[index][:40]}' is not a number with '{table.decimal}' as decimal mark",
                    location=Location(str(path), line),
                    hint="see 'decimal' and 'delimiter' in the settings",
                )
            numbers.append(value)
        yield numbers
