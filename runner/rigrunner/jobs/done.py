"""The outcome of an item, and the protocol of workers."""

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
    """The outcome of a task on one item: a value, or the problem in its place."""

    value: Value | None
    problem: str = ""
    """Why there is no value; empty if there is one."""
    trace: str = ""
    """The traceback of an unexpected problem, which is a bug of this program or of a plugin."""


@dataclass(frozen=True)
class Done(Generic[Item, Value]):
    """An item with its outcome."""

    place: int
    """Index among all items, from 0. Outcomes come in any order."""
    item: Item
    answer: Answer[Value]

    @property
    def problem(self) -> str:
        """Why there is no value; empty if there is one."""
        return self.answer.problem


class Workers(Protocol):
    """Applies a task to items, once to each."""

    def outcomes(
        self, task: Callable[[Item], Value], items: Sequence[Item], stop: StopToken
    ) -> Iterator[Done[Item, Value]]:
        """Yield the outcome of each item, in the order in which they are ready.

        `task` is picklable, and its value depends on the item alone. After the token is set nothing
        more is yielded; unfinished items are dropped.
        """
        ...


def attempt(task: Callable[[Item], Value], item: Item) -> Answer[Value]:
    """Return the task's value of an item; an error becomes a problem as text."""
    try:
        return Answer(task(item))
    except RigrunnerError as error:
        return Answer(None, str(error))
    except Exception as error:  # noqa: BLE001  (a bug at one item is reported, and ends no batch)
        return Answer(None, f"{type(error).__name__}: {error}", traceback.format_exc())


class InProcess:
    """No further process: for a few items, or a debugger. The task need not be picklable."""

    def outcomes(
        self, task: Callable[[Item], Value], items: Sequence[Item], stop: StopToken
    ) -> Iterator[Done[Item, Value]]:
        """Yield the outcome of each item, in their order; see `Workers`."""
        for place, item in enumerate(items):
            if stop.is_set():
                return
            yield Done(place, item, attempt(task, item))
