"""The errors that users see: what is wrong, where, and what to do."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydantic import ValidationError

_LONGEST_NAME = 100
"""Maximum length of a text that is compared with known names, which takes long."""


class ExitCode(IntEnum):
    """Exit codes of the command line; see docs/reference/exit-codes.md."""

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
    WITHDRAWN = 14
    ABORTED = 20
    BUG = 70  # EX_SOFTWARE of sysexits.h
    INTERRUPTED = 130  # 128 + SIGINT, as shells report it


@dataclass(frozen=True, order=True)
class Location:
    """A place in a text file; line and column start at 1."""

    file: str
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        """Return `file:line:column`, which editors and terminals turn into a link."""
        return ":".join(
            str(part) for part in (self.file, self.line, self.column) if part is not None
        )


@dataclass(frozen=True)
class Problem:
    """One problem in a file, with the field, the value and what was expected."""

    message: str
    location: Location | None = None
    field: str = ""
    hint: str = ""

    def __str__(self) -> str:
        """Return the problem as one line."""
        where = f"{self.location}: " if self.location else ""
        field = f"{self.field}: " if self.field else ""
        hint = f" ({self.hint})" if self.hint else ""
        return f"{where}{field}{self.message}{hint}"


class RigrunnerError(Exception):
    """An error that the user can act on; any other exception is a bug."""

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
    """Invalid arguments or options of a command."""

    exit_code = ExitCode.USAGE

    def __init__(self, message: str, *, hint: str = "", field: str = "") -> None:
        super().__init__(message, hint=hint)
        self.field = field
        """The field of a form that it is about; empty where it is about no single one."""


class InvalidFileError(RigrunnerError):
    """A procedure, station or manifest is invalid; has all problems."""

    exit_code = ExitCode.INVALID

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(problems)
        count = len(self.problems)
        super().__init__(f"{count} problem{'s' if count != 1 else ''} found")

    def __str__(self) -> str:
        """Return all problems, one per line."""
        return "\n".join(str(problem) for problem in self.problems)


class TextError(RigrunnerError, ValueError):
    """A text in a file is not valid."""

    exit_code = ExitCode.INVALID

    def __init__(self, message: str, *, column: int = 1, hint: str = "") -> None:
        super().__init__(message, hint=hint)
        self.column = column
        """The character of the text that it refers to, from 1."""


class PluginError(RigrunnerError):
    """A plugin is unknown, broken, or declared twice."""

    exit_code = ExitCode.INVALID


class MissingPackageError(PluginError):
    """A plugin needs an optional package that is not installed."""


class DeviceError(RigrunnerError):
    """A device failed; base class of the four device errors."""

    exit_code = ExitCode.DEVICE


class DeviceNotFoundError(DeviceError):
    """There is no such device, or it is not the expected one."""


class DeviceTimeoutError(DeviceError):
    """The device did not answer in time."""


class DeviceRejectedError(DeviceError):
    """The device refused a request."""


class DeviceLostError(DeviceError):
    """The connection to the device was lost."""


class DataError(RigrunnerError):
    """Recorded data cannot be read, or do not allow what was requested."""

    exit_code = ExitCode.DATA


class AbortedError(RigrunnerError):
    """The run was stopped by a person, an interlock or a signal, which `by` states."""

    exit_code = ExitCode.ABORTED

    def __init__(
        self, message: str, *, location: Location | None = None, hint: str = "", by: str = ""
    ) -> None:
        super().__init__(message, location=location, hint=hint)
        self.by = by


def first_problem(error: ValidationError, whole: str = "") -> str:
    """Return the first problem as 'field: what'; `whole` stands for the document itself."""
    first = error.errors()[0]
    where = ".".join(map(str, first["loc"])) or whole
    return f"{where}: {first['msg']}" if where else first["msg"]


def did_you_mean(
    got: str, known: Iterable[str], otherwise: str = "", *, cutoff: float = 0.6
) -> str:
    """Return a hint with the known name that is nearest, or other words if none is near.

    `cutoff` is the minimum similarity of two names, from 0 to 1, as for
    `difflib.get_close_matches`.
    """
    near = get_close_matches(got[:_LONGEST_NAME], list(known), n=1, cutoff=cutoff)
    return f"did you mean '{near[0]}'?" if near else otherwise
