"""Process the items in processes of this machine, one item at a time in each."""

from __future__ import annotations

import os
from collections import deque
from dataclasses import dataclass, field
from multiprocessing.connection import wait
from typing import TYPE_CHECKING, Any

from rigrunner.jobs.done import Answer, Done, Item, Value
from rigrunner.jobs.worker import Worker

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api.devices import StopToken

PATIENCE_S = 0.2
"""Time between two checks of the stop token."""

ATTEMPTS = 2
"""Attempts at an item whose process died: something else may have killed it."""


def usable_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Processes:
    """`jobs` worker processes; a single one is a separate process too, so the results are the same.

    Each has its own pipe, so that it is known which item a process had when it died. Pools of the
    standard library then wait without end, or fail at every item.
    """

    jobs: int

    def outcomes(
        self, task: Callable[[Item], Value], items: Sequence[Item], stop: StopToken
    ) -> Iterator[Done[Item, Value]]:
        """Yield the outcome of each item; see `Workers`."""
        pool = _Pool(task, items, deque((place, 1) for place in range(len(items))))
        try:
            while not stop.is_set() and pool.is_busy(self.jobs):
                for place, answer in pool.answers():
                    yield Done(place, items[place], answer)
        finally:
            pool.kill_all()


@dataclass(eq=False)
class _Pool:
    """The processes, and the waiting items with their indices and attempts."""

    task: Callable[[Any], Any]
    items: Sequence[Any]
    waiting: deque[tuple[int, int]]
    busy: list[Worker] = field(default_factory=list)

    def is_busy(self, jobs: int) -> bool:
        """Start as many processes as there are items for; return whether any is busy."""
        while self.waiting and len(self.busy) < jobs:
            self._give(Worker(self.task))
        return bool(self.busy)

    def answers(self) -> Iterator[tuple[int, Answer[Any]]]:
        """Yield the outcomes that are ready, and give their processes new items."""
        # A pipe is ready too when its process has died.
        ready = wait([worker.pipe for worker in self.busy], PATIENCE_S)
        for worker in [worker for worker in self.busy if worker.pipe in ready]:
            self.busy.remove(worker)
            answer = worker.answer()
            if answer is None:
                death = worker.death()
                if worker.attempt < ATTEMPTS:
                    # At the end: an item that kills its process does not hold up the others.
                    self.waiting.append((worker.place, worker.attempt + 1))
                else:
                    yield worker.place, Answer(None, f"{death}, {ATTEMPTS} times")
                continue
            place = worker.place
            if self.waiting:
                self._give(worker)
            else:
                worker.end()
            yield place, answer

    def kill_all(self) -> None:
        """Kill all processes; their items can be processed again."""
        for worker in self.busy:
            worker.kill()

    def _give(self, worker: Worker) -> None:
        place, attempt = self.waiting.popleft()
        worker.give(place, self.items[place], attempt)
        self.busy.append(worker)
