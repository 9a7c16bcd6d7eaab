"""Follow the blocks of an active recording in its journal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.runfile.codec import block_from
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.journal import Kind, read_records, skip_records
from rigrunner.runfile.loose import SampleJournal
from rigrunner.runfile.recordings import Shape

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from rigrunner.api.data import Block, Recording
    from rigrunner.api.events import Event


class Tail:
    """Yields each block of a run's latest recording once, to another process than its writer.

    The file is open only while it is read, so that its writer can remove it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.name = ""
        """The name of the recording; empty before its first block."""
        self._end: int | None = None

    def blocks(self, most_behind: int) -> Iterator[Block]:
        """Yield the blocks since the last call; none once the journal is folded.

        If there are more than `most_behind` bytes, older blocks are skipped: the analysis at the
        end has them from the file.
        """
        try:
            self._end = skip_records(self.path, self._end, most_behind)
            for record in read_records(self.path, self._end):
                self._end = record.end
                if record.kind == Kind.BLOCK:
                    self.name, block = block_from(record.payload)
                    yield block
        except FileNotFoundError:
            return

    def begun(self, first: Block, events: Iterable[Event]) -> Recording:
        """Return the recording without its samples, as far as its events are known."""
        names = tuple(first.channels)
        shape = Shape(first.rate_hz, names, 0)
        journal = SampleJournal(self.path, int(self.path.stem), self.name, shape)
        return journal.facts(events).recording(dict.fromkeys(names, np.empty(0)))


def tail_of(folder: Path) -> Tail | None:
    """Return the tail of the latest recording of an active run; None before the first."""
    journals = RunFolder(folder).sample_journals()
    return Tail(journals[-1]) if journals else None
