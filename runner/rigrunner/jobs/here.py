"""Process the items one after the other, in this process."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.jobs.done import Done, Item, Value, attempt

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api.devices import StopToken


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
