"""Turn finished recordings into files in the background: no step waits for it."""

from __future__ import annotations

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Future


class Folding:
    """Folds one recording after the other in a thread; the process waits for it at its end.

    HDF5 compresses without the interpreter's lock, so the recording thread continues. Only names
    are queued; the samples stay on the disk, in complete and synced journals.
    """

    def __init__(self) -> None:
        self._worker = ThreadPoolExecutor(1, "fold")
        self.going: deque[Future[None]] = deque()
        """Folds that were started and not yet checked."""

    def start(self, fold: Callable[[], None]) -> None:
        """Start a fold, which begins after those before it."""
        self.going.append(self._worker.submit(fold))

    def check(self) -> None:
        """Raise the error of a failed fold. Its recording is still complete, in its journal."""
        while self.going and self.going[0].done():
            self.going.popleft().result()

    def wait(self) -> None:
        """Wait until all are done. Failed ones are repeated at sealing. Idempotent."""
        self._worker.shutdown()
