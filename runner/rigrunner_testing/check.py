"""What a check is: a demand in one sentence, the work that shows whether it is met, a way out."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

SubjectT = TypeVar("SubjectT")


class Nonconformity(AssertionError):  # noqa: N818  (the word of ISO 9000, 3.6.9)
    """A demand is not met; the text says what was found, with numbers.

    `fix` says what to do, where that is known better than the check knows it.
    """

    def __init__(self, text: str, *, fix: str = "") -> None:
        super().__init__(text)
        self.fix = fix


class NotApplicable(Exception):  # noqa: N818  (it is no error)
    """The check has nothing to look at; the text says why."""


class State(StrEnum):
    """How a check ended."""

    PASS = "pass"  # noqa: S105  (no password)
    FAIL = "fail"
    NOT_APPLICABLE = "not applicable"
    NOT_JUDGED = "not judged"
    """What it needs has failed, so that it would only fail for the same reason."""


@dataclass(frozen=True)
class Check(Generic[SubjectT]):
    """One demand on a plugin."""

    name: str
    holds: str
    """What is demanded, in one sentence."""
    fix: str
    """What to do where it is not met."""
    work: Callable[[SubjectT], None]
    """Raises Nonconformity or NotApplicable; whatever else it raises is a failure too."""
    moves: bool = False
    """Whether it sets the drives of a device."""
    needs: tuple[str, ...] = ()
    """The checks that must not have failed before this one can be judged."""
    always: bool = False
    """Whether it is done on an instrument even so: that a rig is safe is always looked at."""

    def __str__(self) -> str:
        """Return the name, by which a test is chosen."""
        return self.name


AnyCheck = Check[Any]


@dataclass(frozen=True)
class Finding:
    """What one check found."""

    check: AnyCheck
    state: State
    text: str = ""
    """What was found wrong, or why there was nothing to look at."""
    fix: str = ""
    """What to do about it, where something failed."""


def check(
    *,
    fix: str,
    moves: bool = False,
    needs: tuple[str, ...] = ("can_be_made",),
    always: bool = False,
) -> Callable[[Callable[[SubjectT], None]], Check[SubjectT]]:
    """Make a check of a function: its name is the check's, its docstring the demand."""

    def made(work: Callable[[SubjectT], None]) -> Check[SubjectT]:
        holds = " ".join((work.__doc__ or "").split())
        return Check(work.__name__, holds, fix, work, moves, needs, always)

    return made


def demand(holds: object, otherwise: str, *, fix: str = "") -> None:
    """Raise Nonconformity with that text unless it holds."""
    if not holds:
        raise Nonconformity(otherwise, fix=fix)


def applies(holds: object, otherwise: str) -> None:
    """Raise NotApplicable with that text unless it holds."""
    if not holds:
        raise NotApplicable(otherwise)
