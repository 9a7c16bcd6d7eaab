"""Samples out of a MATLAB file, of version 5 to 7 or 7.3 (which is HDF5)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api import Column, DataError, Location, NotInFileError, RigrunnerError
from rigrunner_plugins.importers.finding import near, numbers
from rigrunner_plugins.importers.matlab_variables import open_variables

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from rigrunner.api import NoSettings
    from rigrunner_plugins.importers.matlab_variables import Node

_NAME = "[A-Za-z][A-Za-z0-9_]*"
_PATH = re.compile(rf"({_NAME}(?:\.{_NAME})*)(?:\(:, *([0-9]{{1,6}})\))?")


@dataclass(frozen=True)
class _Place:
    """Where in a file a column is: variable and fields, and which column of a matrix."""

    text: str
    names: tuple[str, ...]
    number: int | None


@dataclass(frozen=True)
class MatlabImporter:
    """Reads MATLAB files: a column is a vector, `x`, `s.x`, or one of a matrix, `data(:,2)`.

    A group is a structure that holds the recording.
    """

    settings: NoSettings

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return the wanted columns; see `rigrunner.api.importing.Importer`."""
        places = {wanted: _place(wanted, column, group) for wanted, column in columns.items()}
        location = Location(str(path))
        try:
            with open_variables(path) as root:
                return {
                    wanted: Column(_values(root, wanted, place, path))
                    for wanted, place in places.items()
                }
        except RigrunnerError:
            raise
        except OSError as error:
            problem = error.strerror or "is not a MATLAB file, or is damaged"
            raise DataError(problem, location=location) from error
        except Exception as error:
            what = f"{type(error).__name__}: {error}"
            raise DataError(
                f"is not a MATLAB file, or is damaged: {what[:120]}", location=location
            ) from error


def _place(wanted: str, column: int | str, group: str) -> _Place:
    text = f"{group}.{column}" if group else str(column)
    match = _PATH.fullmatch(text)
    if match is None:
        raise NotInFileError(
            f"'{text}' of '{wanted}' names nothing in a MATLAB file",
            wanted=wanted,
            hint="such as x, recording.x, or data(:,2)",
        )
    return _Place(text, tuple(match[1].split(".")), int(match[2]) if match[2] else None)


def _values(root: Node, wanted: str, place: _Place, path: Path) -> NDArray[np.float64]:
    node, what = root, f"'{place.text}'"
    for depth, name in enumerate(place.names):
        if name not in node.names():
            full_name = ".".join(place.names[: depth + 1])
            raise NotInFileError(
                f"'{full_name}' of '{wanted}' is not there",
                wanted=wanted,
                location=Location(str(path)),
                hint=near(name, node.names(), "there are"),
            )
        node = node.member(name)
    if node.kind != "numbers":
        raise DataError(f"{what} is {node.kind}, not numbers", location=Location(str(path)))
    matrix = node.array()
    if matrix.ndim != 2:  # noqa: PLR2004  (rows and columns)
        raise DataError(f"{what} has {matrix.ndim} dimensions", location=Location(str(path)))
    if place.number is not None:
        if not 1 <= place.number <= matrix.shape[1]:
            raise DataError(
                f"{what} is not there: the matrix has {matrix.shape[1]} columns",
                location=Location(str(path)),
            )
        return numbers(matrix[:, place.number - 1], what, path)
    if 1 not in matrix.shape and matrix.size:
        raise DataError(
            f"{what} is a matrix of {matrix.shape[0]} x {matrix.shape[1]}",
            location=Location(str(path)),
            hint=f"say which of its columns: {place.text}(:,1)",
        )
    return numbers(matrix.reshape(-1), what, path)
