"""What a check is: a demand in one sentence, the work that shows whether it is met, a way out."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

SubjectT = TypeVar("SubjectT")


class Nonconformity(AssertionError):  # noqa: N818  (the word of ISO 9000, 3.6.9)
    """A demand is not met; the text says what was found, with numbers."""


class NotApplicable(Exception):  # noqa: N818  (it is no error)
    """The check has nothing to look at; the text says why."""


class State(StrEnum):
    """How a check ended."""

    PASS = "pass"  # noqa: S105  (no password)
    FAIL = "fail"
    NOT_APPLICABLE = "not applicable"


@dataclass(frozen=True)
class Check(Generic[SubjectT]):
    """One demand on a plugin."""

    name: str
    holds: str
    """What is demanded, in one sentence."""
    mend: str
    """What to do where it is not met."""
    work: Callable[[SubjectT], None]
    """Raises Nonconformity or NotApplicable; whatever else it raises is a failure too."""
    moves: bool = False
    """Whether it sets the drives of a device."""

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


def check(
    *, mend: str, moves: bool = False
) -> Callable[[Callable[[SubjectT], None]], Check[SubjectT]]:
    """Make a check of a function: its name is the check's, its docstring the demand."""

    def made(work: Callable[[SubjectT], None]) -> Check[SubjectT]:
        holds = " ".join((work.__doc__ or "").split())
        return Check(work.__name__, holds, mend, work, moves)

    return made


def demand(holds: object, otherwise: str) -> None:
    """Raise Nonconformity with that text unless it holds."""
    if not holds:
        raise Nonconformity(otherwise)


def applies(holds: object, otherwise: str) -> None:
    """Raise NotApplicable with that text unless it holds."""
    if not holds:
        raise NotApplicable(otherwise)
