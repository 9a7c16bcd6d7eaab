"""The importer old_importer: columns of numbers below a line of names."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from rigrunner.api.errors import DataError, Location
from rigrunner.api.hooks import ImporterRecord, NoSettings, hookimpl
from rigrunner.api.importing import Column, Importer, NotInFileError

api_version = 1


class OldImporter:
    """Satisfies `rigrunner.api.importing.Importer`."""

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return the wanted columns as they stand in the file; raise a DataError."""
        if group:
            raise NotInFileError(f"such a file has no groups, but '{group}' is asked for")
        names, *rows = _lines(path)
        where = {wanted: _position(wanted, at, names, path) for wanted, at in columns.items()}
        found: dict[str, list[float]] = {wanted: [] for wanted in columns}
        for line, cells in enumerate(rows, 2):
            for wanted, index in where.items():
                found[wanted].append(_number(cells, index, Location(str(path), line)))
        return {wanted: Column(np.array(values)) for wanted, values in found.items()}


def _lines(path: Path) -> list[list[str]]:
    try:
        lines = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
    except UnicodeDecodeError as error:
        raise DataError("is not UTF-8", location=Location(str(path))) from error
    except OSError as error:
        reason = f"cannot be read: {error.strerror or error}"
        raise DataError(reason, location=Location(str(path))) from error
    if len(lines) < 2:
        raise DataError("has no row of numbers", location=Location(str(path)))
    return lines


def _position(wanted: str, column: int | str, names: Sequence[str], path: Path) -> int:
    """Return the index of a column by its name, or by its number from 1."""
    if isinstance(column, int) and 1 <= column <= len(names):
        return column - 1
    found = [index for index, name in enumerate(names) if name == column]
    if len(found) != 1:
        raise NotInFileError(
            f"the column '{column}' of '{wanted}' is there {len(found)} times",
            wanted=wanted,
            location=Location(str(path), 1),
            hint=f"columns: {', '.join(names)}",
        )
    return found[0]


def _number(cells: Sequence[str], index: int, place: Location) -> float:
    if index >= len(cells):
        raise DataError(f"has {len(cells)} columns, {index + 1} are needed", location=place)
    try:
        value = float(cells[index])
    except ValueError as error:
        raise DataError(f"'{cells[index][:40]}' is not a number", location=place) from error
    if not np.isfinite(value):
        raise DataError(f"'{cells[index][:40]}' is not finite", location=place)
    return value


def _make(_: NoSettings) -> Importer:
    return OldImporter()


@hookimpl
def rigrunner_importers() -> list[ImporterRecord]:
    """Tell Rigrunner what is in this file."""
    return [
        ImporterRecord(
            name="old_importer",
            help="Old importer: columns parted by blanks",
            factory=_make,
        )
    ]
