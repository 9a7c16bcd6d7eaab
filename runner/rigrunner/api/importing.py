"""What an importer is: it reads columns of numbers out of a file that another program wrote."""

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
    """Numbers as they stand in a file, and what the file itself says of them."""

    values: Array
    """Shape (n,), finite; no unit is converted."""
    unit: str = ""
    """As the file spells it; empty where it states none."""
    interval_s: float | None = None
    """Between two samples; None where the file states none."""
    interval_within_s: float = 0.0
    """How far the stated interval may be from the true one, because of the digits written."""
    started: datetime | None = None
    """When the column's time begins: with its zone, or in the local time of the rig without."""
    offset_s: float = 0.0
    """When the first sample was taken, counted from there."""
    goes: tuple[tuple[int, datetime], ...] = ()
    """Of what was written in several goes: with which sample, from 0, each but the first began, and
    when that sample was taken."""


class Importer(Protocol):
    """Reads one kind of file."""

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return the wanted columns of a file, by the same names.

        `group` is the part of the file that holds the recording: a group, a segment, a structure;
        '' where a file holds only one. No more is kept in memory than what is wanted. Raises
        NotInFileError for a column or group that is not there, and DataError naming file, and line,
        group or column, for a file that is not of the kind, or is damaged or cut short; whatever
        the file holds, nothing else.
        """
        ...


class NotInFileError(DataError):
    """A column or a group is not in the file, or is there twice: who named it may be wrong."""

    def __init__(
        self, message: str, *, wanted: str = "", location: Location | None = None, hint: str = ""
    ) -> None:
        super().__init__(message, location=location, hint=hint)
        self.wanted = wanted
        """By the caller's name; empty where it is the group."""
