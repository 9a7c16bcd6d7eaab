"""Importers read columns of numbers from files of other programs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.data import Array
    from rigrunner.api.errors import Location


@dataclass(frozen=True, eq=False)
class Column:
    """Numbers as in the file, and what the file states about them."""

    values: Array
    """Shape (n,), finite; not converted."""
    unit: str = ""
    """As spelled in the file; empty if not stated."""
    interval_s: float | None = None
    """Time between samples; None if not stated."""
    interval_within_s: float = 0.0
    """Uncertainty of the interval from its number of digits."""
    started: datetime | None = None
    """Time zero of the column: with a zone, or in the local time of the rig."""
    offset_s: float = 0.0
    """Time of the first sample, relative to `started`."""
    goes: tuple[tuple[int, datetime], ...] = ()
    """For data written in several parts: index of the first sample of each later part, and its
    time."""


class Importer(Protocol):
    """Reads one type of file."""

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return the requested columns of a file, by the same names.

        `group` is the part of the file with the recording: a group, a segment, a structure; '' for
        the only one. Keeps only the requested columns in memory. Raises NotInFileError for a
        missing column or group, and DataError naming file, and line, group or column, for a file of
        another type, or one that is damaged or truncated; no other exception.
        """
        ...


class NotInFileError(DataError):
    """A column or a group is missing or not unique: the name may be wrong."""

    def __init__(
        self, message: str, *, wanted: str = "", location: Location | None = None, hint: str = ""
    ) -> None:
        super().__init__(message, location=location, hint=hint)
        self.wanted = wanted
        """Name used by the caller; empty for the group."""
