"""What became of one item, and who does the items."""

from __future__ import annotations

import traceback
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from rigrunner.api.errors import RigrunnerError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api.devices import StopToken

Item = TypeVar("Item")
Value = TypeVar("Value")


@dataclass(frozen=True)
class Answer(Generic[Value]):
    """What a task gave of one item: a value, or the problem that took its place."""

    value: Value | None
    problem: str = ""
    """Why there is no value, in words; empty where there is one."""
    trace: str = ""
    """The traceback of a problem that nobody foresaw: a bug of ours or of a plugin."""


@dataclass(frozen=True)
class Done(Generic[Item, Value]):
    """An item and what was made of it."""

    place: int
    """Among all items, counted from 0: outcomes come in any order."""
    item: Item
    answer: Answer[Value]

    @property
    def problem(self) -> str:
        """Why there is no value; empty where there is one."""
        return self.answer.problem


class Workers(Protocol):
    """Does the items of a task, each once."""

    def outcomes(
        self, task: Callable[[Item], Value], items: Sequence[Item], stop: StopToken
    ) -> Iterator[Done[Item, Value]]:
        """Yield what becomes of each item, in the order in which they are ready.

        `task` is picklable, and its value follows from the item alone. Once the token is set no
        more come: what is under way is dropped.
        """
        ...


def attempt(task: Callable[[Item], Value], item: Item) -> Answer[Value]:
    """Return the task's value of an item; an error becomes a problem in words."""
    try:
        return Answer(task(item))
    except RigrunnerError as error:
        return Answer(None, str(error))
    except Exception as error:  # noqa: BLE001  (a bug at one item is told, and ends no batch)
        return Answer(None, f"{type(error).__name__}: {error}", traceback.format_exc())
