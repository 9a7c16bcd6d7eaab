"""Fit any columns of a CSV file, by any fit plugin."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.data import Points
from rigrunner.api.errors import InvalidFileError, Location, Problem
from rigrunner.api.plugin_refs import FitRef
from rigrunner.yamlfile import parse, validate
from rigrunner.yamlfile.problems import suggestion
from rigrunner.yamlfile.reader import read_text

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rigrunner.api.analysis import Curve
    from rigrunner.api.data import Array
    from rigrunner.registry import Registry


def fit_of_table(
    table: Path, *, y: str, x: Sequence[str], u: str | None, fit: str, registry: Registry
) -> Curve:
    """Return the curve of column `y` over the columns `x`, by a fit as a procedure writes it.

    `u` is the column of the standard uncertainties of y. Units are the table's own, so points have
    none. Raises InvalidFileError with the place for errors in the table or in the fit, and
    DataError if the points do not allow it.
    """
    reference = validate(FitRef, parse(fit, "--fit"))
    rows = _Rows.read(table)
    columns = [rows.column(name) for name in x]
    points = Points(
        x=columns[0] if len(columns) == 1 else np.column_stack(columns),
        y=rows.column(y),
        u_y=None if u is None else rows.column(u),
        x_unit="",
        y_unit="",
        regressors=tuple(x) if len(columns) > 1 else (),
        x_name=x[0],
        y_name=y,
    )
    curve: Curve = registry.make("fit", reference.name, reference.settings)(points)
    return curve


@dataclass(frozen=True)
class _Rows:
    file: str
    names: Sequence[str]
    rows: Sequence[tuple[int, Sequence[str]]]
    """The rows, each with its line."""

    @classmethod
    def read(cls, path: Path) -> _Rows:
        """Read a CSV file whose first line has the names of the columns."""
        reader = csv.reader(read_text(path).splitlines(), strict=True)
        try:
            lines = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if row]
        except csv.Error as error:
            raise _invalid(str(path), reader.line_num, f"it is not CSV: {error}") from error
        if not lines:
            raise _invalid(str(path), 1, "the table is empty")
        (_, names), *rows = lines
        for line, row in rows:
            if len(row) != len(names):
                raise _invalid(
                    str(path), line, f"{len(row)} cells; the first line has {len(names)}"
                )
        return cls(str(path), names, rows)

    def column(self, name: str) -> Array:
        """Return the numbers of a column, shape (n,)."""
        if self.names.count(name) != 1:
            if name in self.names:
                raise _invalid(self.file, 1, f"there are several columns '{name}'")
            hint = suggestion(name, self.names, "columns")
            raise _invalid(self.file, 1, f"there is no column '{name}'", hint)
        index = self.names.index(name)
        numbers = []
        for line, row in self.rows:
            number = _number(row[index])
            if number is None:
                raise _invalid(self.file, line, f"{name}: '{row[index][:40]}' is not a number")
            numbers.append(number)
        return np.array(numbers)


def _number(cell: str) -> float | None:
    try:
        number = float(cell)
    except ValueError:
        return None
    # Python's float would take 1_000 for a number.
    return number if math.isfinite(number) and "_" not in cell else None


def _invalid(file: str, line: int, message: str, hint: str = "") -> InvalidFileError:
    return InvalidFileError([Problem(message, Location(file, line), hint=hint)])
