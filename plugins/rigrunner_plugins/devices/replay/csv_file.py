"""Samples out of a CSV file, as they stand there: no unit is converted here."""

from __future__ import annotations

import csv
import math
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError, Location

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from rigrunner.api.data import Array
    from rigrunner_plugins.devices.replay.settings import TableSettings


def read_csv(
    path: Path, columns: Mapping[str, int | str], table: TableSettings
) -> dict[str, Array]:
    """Return each channel's samples, shape (n,), from its column by name or number from 1.

    Raises DataError naming file and line.
    """
    delimiter = "\t" if table.delimiter == "tab" else table.delimiter
    try:
        with path.open(newline="", encoding=_encoding(table)) as file:
            for _ in range(table.skip_lines):
                next(file, "")
            reader = csv.reader(file, delimiter=delimiter)
            header = next(reader, []) if table.header else []
            where = _find(columns, [name.strip() for name in header], path, table)
            rows = _rows(reader, list(where.values()), path, table)
            samples = np.array(list(rows), dtype=np.float64).reshape(-1, len(where))
    except UnicodeDecodeError as error:
        raise DataError(f"is not {table.encoding}", location=Location(str(path))) from error
    except csv.Error as error:
        raise DataError(f"is not CSV: {error}", location=Location(str(path))) from error
    return {name: samples[:, index] for index, name in enumerate(where)}


def _encoding(table: TableSettings) -> str:
    return "utf-8-sig" if table.encoding == "utf-8" else table.encoding


def _find(
    columns: Mapping[str, int | str], header: list[str], path: Path, table: TableSettings
) -> Mapping[str, int]:
    """Return the index of each channel's column."""
    found = {}
    line = table.skip_lines + 1
    for channel, column in columns.items():
        if isinstance(column, int):
            found[channel] = column - 1
        elif header.count(column) == 1:
            found[channel] = header.index(column)
        else:
            problem = "is there twice" if column in header else "is not there"
            raise DataError(
                f"the column '{column}' of channel '{channel}' {problem}",
                location=Location(str(path), line),
                hint=f"columns: {', '.join(header)}" if table.header else "give its number instead",
            )
    return found


def _rows(
    reader: Iterator[list[str]], indices: list[int], path: Path, table: TableSettings
) -> Iterator[list[float]]:
    first = table.skip_lines + 1 + table.header
    for line, row in enumerate(reader, first):
        if not row:
            continue
        if len(row) <= max(indices):
            raise DataError(
                f"has {len(row)} columns, {max(indices) + 1} are needed",
                location=Location(str(path), line),
                hint=f"the delimiter is set to '{table.delimiter}'",
            )
        yield [_number(row[index], path, line, table) for index in indices]


def _number(cell: str, path: Path, line: int, table: TableSettings) -> float:
    text = cell.strip()
    other = "," if table.decimal == "." else "."
    if other not in text and "_" not in text:
        try:
            number = float(text.replace(",", "."))
        except ValueError:
            number = math.nan
        if math.isfinite(number):
            return number
    raise DataError(
        f"'{cell}' is not a number with '{table.decimal}' as decimal mark",
        location=Location(str(path), line),
        hint="see 'decimal' and 'delimiter' in the device's settings",
    )
