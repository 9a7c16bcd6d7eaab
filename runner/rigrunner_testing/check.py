"""A check: a requirement in one sentence, the code that tests it, and a remedy."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

SubjectT = TypeVar("SubjectT")


class Nonconformity(AssertionError):  # noqa: N818  (the word of ISO 9000, 3.6.9)
    """A requirement is not met; the text says what was found, with numbers.

    `fix` is a remedy that is more precise than that of the check.
    """

    def __init__(self, text: str, *, fix: str = "") -> None:
        super().__init__(text)
        self.fix = fix


class NotApplicable(Exception):  # noqa: N818  (it is no error)
    """The check does not apply; the text says why."""


class State(StrEnum):
    """How a check ended."""

    PASS = "pass"  # noqa: S105  (no password)
    FAIL = "fail"
    NOT_APPLICABLE = "not applicable"
    NOT_JUDGED = "not judged"
    """A required check failed, so this one would fail for the same reason."""


@dataclass(frozen=True)
class Check(Generic[SubjectT]):
    """One requirement on a plugin."""

    name: str
    holds: str
    """The requirement, in one sentence."""
    fix: str
    """The remedy."""
    work: Callable[[SubjectT], None]
    """Raises Nonconformity or NotApplicable; any other exception is a failure too."""
    moves: bool = False
    """Whether it sets the drives of a device."""
    needs: tuple[str, ...] = ()
    """The checks that must not have failed before."""
    always: bool = False
    """Whether it runs on a real instrument even so: a rig must always be confirmed safe."""

    def __str__(self) -> str:
        """Return the name, which selects a test."""
        return self.name


AnyCheck = Check[Any]


@dataclass(frozen=True)
class Finding:
    """The result of one check."""

    check: AnyCheck
    state: State
    text: str = ""
    """What is wrong, or why the check does not apply."""
    fix: str = ""
    """The remedy, after a failure."""


def check(
    *,
    fix: str,
    moves: bool = False,
    needs: tuple[str, ...] = ("can_be_made",),
    always: bool = False,
) -> Callable[[Callable[[SubjectT], None]], Check[SubjectT]]:
    """Make a check of a function: its name is the check's, its docstring the requirement."""

    def decorate(work: Callable[[SubjectT], None]) -> Check[SubjectT]:
        holds = " ".join((work.__doc__ or "").split())
        return Check(work.__name__, holds, fix, work, moves, needs, always)

    return decorate


def demand(holds: object, otherwise: str, *, fix: str = "") -> None:
    """Raise Nonconformity with that text unless it holds."""
    if not holds:
        raise Nonconformity(otherwise, fix=fix)


def applies(holds: object, otherwise: str) -> None:
    """Raise NotApplicable with that text unless it holds."""
    if not holds:
        raise NotApplicable(otherwise)
