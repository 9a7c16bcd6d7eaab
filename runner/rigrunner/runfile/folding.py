"""Finished recordings become files of their own in the background: no step waits for it."""

from __future__ import annotations

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Future


class Folding:
    """Does one fold after the other in a thread of its own; a process that ends waits for it.

    HDF5 compresses without the interpreter's lock, so that the thread that records goes on. What
    waits is a name each; the samples stay on the disk, in journals that are whole and synced.
    """

    def __init__(self) -> None:
        self._worker = ThreadPoolExecutor(1, "fold")
        self.going: deque[Future[None]] = deque()
        """What was started and was not looked at since."""

    def start(self, fold: Callable[[], None]) -> None:
        """Fold once those before it are done."""
        self.going.append(self._worker.submit(fold))

    def check(self) -> None:
        """Raise what a fold has raised; its recording is still whole, in its journal."""
        while self.going and self.going[0].done():
            self.going.popleft().result()

    def wait(self) -> None:
        """Wait until all are done; what failed is folded anew at sealing. Idempotent."""
        self._worker.shutdown()
