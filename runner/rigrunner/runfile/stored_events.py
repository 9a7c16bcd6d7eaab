"""The events of a stored run in memory: compressed, and decoded each time they are gone through."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from itertools import chain
from typing import TYPE_CHECKING, Any

from rigrunner.api.events import Event, Scanned, StepEnded, StepStarted
from rigrunner.runfile.attempts import Attempts
from rigrunner.runfile.codec import event_from, event_record, event_unpacked
from rigrunner.runfile.compressed import Compressed
from rigrunner.runfile.digest import lines_of
from rigrunner.runfile.journal import Kind
from rigrunner.runfile.measurements import measurement_digest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from rigrunner.runfile.attempts import MeasuredRows

FROM: Mapping[int, Callable[[bytes], Event | None]] = {
    Kind.EVENT: event_from,
    Kind.PACKED: event_unpacked,
}
"""How to decode a record of an event, by its kind."""
_PIECE = 1000
"""Events that are compressed together."""


class StoredEvents(Sequence[Event]):
    """All events of a run, in order, and the rows that they measured."""

    def __init__(self, events: Iterable[Event] = (), *, passed: int | None = None) -> None:
        """Hold events and rows; or, `passed` for a version of the layout, only what checks need.

        These are the outline and the digests of the rows.
        """
        self._keeps_events = passed is None
        self._digests: str | None = None
        self._records = Compressed()
        """Each with its kind as its first byte."""
        self._latest: list[bytes] = []
        digest = None if passed is None else partial(measurement_digest, version=passed)
        self._attempts = Attempts(digest)
        self.outline: list[Event] = []
        """All but points of scans, and steps that neither record nor take a zero."""
        for event in events:
            self.take(*event_record(event))

    def take(self, kind: int, payload: bytes) -> Event | None:
        """Add the event of a record and return it; None for a kind that this version lacks."""
        event = FROM[kind](payload)
        if event is None:
            return None
        self._attempts.take(event)
        if self._keeps_events:
            self._latest.append(bytes((kind,)) + payload)
        if len(self._latest) == _PIECE:
            self._records.add(self._latest)
            self._latest = []
        match event:
            case Scanned():
                pass
            case StepStarted() | StepEnded() if not event.recording and event.action != "zero":
                pass
            case _:
                self.outline.append(event)
        return event

    @cached_property
    def measured(self) -> MeasuredRows:
        """The rows that they measured; no event is taken after that."""
        measured = self._attempts.measured()
        del self._attempts  # they hold more than the rows
        return measured

    def row_digests(self, version: int) -> str:
        """Return the digests of the rows that count, one a line; they are made once."""
        if self._digests is None:
            rows, digests = self.measured.rows, self.measured.digests
            computed = (measurement_digest(row, version) for row in rows)
            self._digests = lines_of(computed) if digests is None else digests
        return self._digests

    def __len__(self) -> int:
        return len(self._records) + len(self._latest)

    def __iter__(self) -> Iterator[Event]:
        for record in chain(self._records, self._latest):
            event = FROM[record[0]](record[1:])
            assert event is not None  # noqa: S101  (such records are not taken)
            yield event

    def __getitem__(self, which: Any) -> Any:
        return tuple(self)[which]
