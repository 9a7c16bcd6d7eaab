"""The one family of errors that a user may see: what, where, and what to do."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

_LONGEST_NAME = 100
"""Characters that are compared with known names: a whole text takes too long."""


class ExitCode(IntEnum):
    """The exit codes of the command line; the table of docs/reference/exit-codes.md."""

    PASS = 0
    FAIL = 1
    USAGE = 2
    INVALID = 3
    DEVICE = 4
    DATA = 5
    UNDECIDED = 10
    REPLACED = 11
    UNPROVEN = 12
    REVISED = 13
    ABORTED = 20
    BUG = 70
    INTERRUPTED = 130


@dataclass(frozen=True, order=True)
class Location:
    """A place in a text file; line and column count from 1."""

    file: str
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        """Return `file:line:column`, as editors and terminals make it clickable."""
        return ":".join(
            str(part) for part in (self.file, self.line, self.column) if part is not None
        )


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong in a file, with the field, what was got and what is allowed."""

    message: str
    location: Location | None = None
    field: str = ""
    hint: str = ""

    def __str__(self) -> str:
        """Return the problem as one line for a terminal or a log."""
        where = f"{self.location}: " if self.location else ""
        field = f"{self.field}: " if self.field else ""
        hint = f" ({self.hint})" if self.hint else ""
        return f"{where}{field}{self.message}{hint}"


class RigrunnerError(Exception):
    """An error that the user can act on; anything else that is raised is a bug."""

    exit_code = ExitCode.BUG

    def __init__(self, message: str, *, location: Location | None = None, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.location = location
        self.hint = hint

    def __str__(self) -> str:
        """Return the error as one line."""
        return str(Problem(self.message, self.location, hint=self.hint))


class UsageError(RigrunnerError):
    """The command was called with invalid arguments or options."""

    exit_code = ExitCode.USAGE


class InvalidFileError(RigrunnerError):
    """A procedure, station or manifest is not valid; carries every problem found."""

    exit_code = ExitCode.INVALID

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(problems)
        count = len(self.problems)
        super().__init__(f"{count} problem{'s' if count != 1 else ''} found")

    def __str__(self) -> str:
        """Return all problems, one a line."""
        return "\n".join(str(problem) for problem in self.problems)


class TextError(RigrunnerError, ValueError):
    """A text in a file is not allowed there."""

    exit_code = ExitCode.INVALID

    def __init__(self, message: str, *, column: int = 1, hint: str = "") -> None:
        super().__init__(message, hint=hint)
        self.column = column
        """Which character of the text it is about, from 1."""


class PluginError(RigrunnerError):
    """A plugin is unknown, broken, or declared twice."""

    exit_code = ExitCode.INVALID


class MissingPackageError(PluginError):
    """A plugin needs an optional package that is not installed."""


class DeviceError(RigrunnerError):
    """A device did not do what it was asked; the base of the four device errors."""

    exit_code = ExitCode.DEVICE


class DeviceNotFoundError(DeviceError):
    """There is no such device, or it is not the one it should be."""


class DeviceTimeoutError(DeviceError):
    """The device did not answer in time."""


class DeviceRejectedError(DeviceError):
    """The device refused what it was asked."""


class DeviceLostError(DeviceError):
    """The connection to the device broke."""


class DataError(RigrunnerError):
    """Recorded data cannot be read, or do not allow what is asked of them."""

    exit_code = ExitCode.DATA


class AbortedError(RigrunnerError):
    """The run was stopped: by a person, an interlock or a signal; `by` says by which."""

    exit_code = ExitCode.ABORTED

    def __init__(
        self, message: str, *, location: Location | None = None, hint: str = "", by: str = ""
    ) -> None:
        super().__init__(message, location=location, hint=hint)
        self.by = by


def did_you_mean(
    got: str, known: Iterable[str], otherwise: str = "", *, cutoff: float = 0.6
) -> str:
    """Return as a hint which of the known names is meant, or other words where none is near.

    `cutoff` is how alike two names have to be, from 0 to 1, as of `difflib.get_close_matches`.
    """
    from difflib import get_close_matches  # noqa: PLC0415  (only a wrong name needs it)

    near = get_close_matches(got[:_LONGEST_NAME], list(known), n=1, cutoff=cutoff)
    return f"did you mean '{near[0]}'?" if near else otherwise
