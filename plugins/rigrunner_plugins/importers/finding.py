"""Columns by name or number, and the errors of all importers for missing or unusable ones."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError, Location, NotInFileError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from rigrunner.api import Array

_MOST_NAMES = 20
_LONGEST_NAME = 60


def position(wanted: str, column: int | str, names: Sequence[str], place: Location) -> int:
    """Return the index in `names` of a column by its name, or by its number from 1.

    Raises NotInFileError with the names that come nearest.
    """
    if isinstance(column, int):
        if 1 <= column <= len(names):
            return column - 1
        message = f"there is no column {column} for '{wanted}'"
        raise NotInFileError(
            message, wanted=wanted, location=place, hint=f"there are {len(names)} columns"
        )
    indices = [index for index, name in enumerate(names) if name == column]
    if len(indices) == 1:
        return indices[0]
    problem = "is given twice" if indices else "is not there"
    raise NotInFileError(
        f"the column '{column}' of '{wanted}' {problem}",
        wanted=wanted,
        location=place,
        hint="give its number instead" if indices else near(column, names, "columns"),
    )


def near(name: str, names: Sequence[str], what: str) -> str:
    """Return the names that come nearest, or else all that there are, as a hint."""
    shown = [full_name[:_LONGEST_NAME] for full_name in names]
    by_case = {short_name.lower(): short_name for short_name in shown}
    matches = difflib.get_close_matches(name[:_LONGEST_NAME].lower(), by_case, n=3, cutoff=0.5)
    if matches and len(shown) > 1:
        return f"did you mean {' or '.join(repr(by_case[match]) for match in matches)}?"
    more = f", and {len(shown) - _MOST_NAMES} more" if len(shown) > _MOST_NAMES else ""
    return f"{what}: {', '.join(shown[:_MOST_NAMES]) or 'none'}{more}"


def numbers(array: NDArray[np.generic], what: str, path: Path) -> Array:
    """Return an array of a file as numbers, shape (n,).

    Raises DataError where it is no list of real numbers, is empty, or one of it is not finite.
    """
    place = Location(str(path))
    if np.iscomplexobj(array):
        raise DataError(f"{what} has complex numbers", location=place)
    if array.ndim != 1 or array.dtype.kind not in "biuf":
        raise DataError(f"{what} is not a list of numbers", location=place)
    samples = np.asarray(array, dtype=np.float64)
    if not samples.size:
        raise DataError(f"{what} is empty", location=place)
    finite = np.isfinite(samples)
    if not finite.all():
        at = int(np.argmin(finite))
        raise DataError(f"{what} is not finite at sample {at + 1} ({samples[at]})", location=place)
    return samples
