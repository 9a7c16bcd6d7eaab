"""Does the items in processes of this machine, one item at a time in each."""

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
"""Between two looks at the stop token."""

ATTEMPTS = 2
"""At an item whose process died: it may have been in the way of something else."""


def usable_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Processes:
    """So many processes; even a single one is none of ours, so that the numbers are the same.

    Each has a pipe of its own, so that it is known which item a process was at when it died: the
    pools of the standard library wait for ever then, or give up on every item.
    """

    jobs: int

    def outcomes(
        self, task: Callable[[Item], Value], items: Sequence[Item], stop: StopToken
    ) -> Iterator[Done[Item, Value]]:
        """Yield what becomes of each item; see `Workers`."""
        crew = _Crew(task, items, deque((place, 1) for place in range(len(items))))
        try:
            while not stop.is_set() and crew.is_busy(self.jobs):
                for place, answer in crew.answers():
                    yield Done(place, items[place], answer)
        finally:
            crew.dismiss()


@dataclass(eq=False)
class _Crew:
    """The processes, and the items that wait: their places, and which attempt it would be."""

    task: Callable[[Any], Any]
    items: Sequence[Any]
    waiting: deque[tuple[int, int]]
    busy: list[Worker] = field(default_factory=list)

    def is_busy(self, jobs: int) -> bool:
        """Begin as many processes as there are items for; say whether any is at work."""
        while self.waiting and len(self.busy) < jobs:
            self._give(Worker(self.task))
        return bool(self.busy)

    def answers(self) -> Iterator[tuple[int, Answer[Any]]]:
        """Yield what has become of items by now, and give their processes others."""
        ready = wait([each.pipe for each in self.busy], PATIENCE_S)
        for worker in [each for each in self.busy if each.pipe in ready]:
            self.busy.remove(worker)
            answer = worker.answer()
            if answer is None:
                yield from self._died(worker)
                continue
            place = worker.place
            if self.waiting:
                self._give(worker)
            else:
                worker.end()
            yield place, answer

    def dismiss(self) -> None:
        """End all processes at once: what they are at can be done again."""
        for worker in self.busy:
            worker.kill()

    def _give(self, worker: Worker) -> None:
        place, attempt = self.waiting.popleft()
        worker.give(place, self.items[place], attempt)
        self.busy.append(worker)

    def _died(self, worker: Worker) -> Iterator[tuple[int, Answer[Any]]]:
        death = worker.death()
        if worker.attempt < ATTEMPTS:
            self.waiting.append((worker.place, worker.attempt + 1))
        else:
            yield worker.place, Answer(None, f"{death}, {ATTEMPTS} times")
