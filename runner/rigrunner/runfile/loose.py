"""Read a run that is not sealed: its journal, finished recordings, and journals of samples."""

from __future__ import annotations

import struct
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.errors import DataError
from rigrunner.api.events import Answer, Outcome, Scanned, StepEnded, StepStarted
from rigrunner.clock import utc_text
from rigrunner.hdf5_reading import objects, open_file
from rigrunner.runfile.added_units import define_units_of
from rigrunner.runfile.attempts import superseded
from rigrunner.runfile.codec import block_from, event_record, header_from, truth_from
from rigrunner.runfile.compressed import LongText
from rigrunner.runfile.digest import run_digest
from rigrunner.runfile.durable import reading
from rigrunner.runfile.elapsed import with_elapsed
from rigrunner.runfile.journal import Kind, read_records, unread_bytes
from rigrunner.runfile.model import RunHeader, RunInfo, StoredRun
from rigrunner.runfile.parts import end_of, zeros_in_force
from rigrunner.runfile.recordings import (
    Shape,
    assemble,
    facts_of,
    read_facts,
    read_recording,
    stored_bytes,
)
from rigrunner.runfile.scratch import Scratch
from rigrunner.runfile.stored_events import FROM, StoredEvents
from rigrunner.runfile.stored_samples import IN_MEMORY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping
    from pathlib import Path

    import h5py

    from rigrunner.api.data import Block, Recording
    from rigrunner.api.events import Event
    from rigrunner.runfile.folder import RunFolder
    from rigrunner.runfile.recordings import RecordingFacts


_T = TypeVar("_T")
PART_GROUP = "recording"
NEVER_ENDED = "the run has not ended, or its program was killed"


@dataclass(frozen=True)
class Journal:
    """The content of the journal of events."""

    header: RunHeader
    events: StoredEvents
    truth: Mapping[str, Mapping[str, float]]
    notes: tuple[str, ...]
    records_end: int
    """The end of its last intact record in the file."""
    format: int
    """The version of the layout when the run began."""

    def zeros(self) -> tuple[dict[str, float], dict[str, str]]:
        """Return the latest zero of each channel, and the units."""
        values: dict[str, float] = {}
        units: dict[str, str] = {}
        for event in self.events.outline:
            if isinstance(event, StepEnded) and event.action == "zero" and event.ok:
                values |= event.values
                units |= event.units
        return values, units

    def end(self) -> tuple[str, str, str]:
        """Return when the run ended, its outcome and the reason."""
        if (last := end_of(self.events.outline)) is not None:
            return last.utc, str(last.outcome), last.reason
        latest_utc = self.events[-1].utc if self.events else self.header.started_utc
        return latest_utc, str(Outcome.ERROR), NEVER_ENDED


@dataclass(frozen=True)
class SampleJournal:
    """The blocks of one recording that is not yet a file of its own."""

    path: Path
    number: int
    name: str
    shape: Shape
    is_damaged: bool = False
    """Whether there are bytes after its last intact block. A finished recording has none."""

    def blocks(self) -> Iterator[Block]:
        """Yield the intact blocks."""
        records = read_records(self.path)
        return (block_from(record.payload)[1] for record in records if record.kind == Kind.BLOCK)

    def facts(self, events: Iterable[Event]) -> RecordingFacts:
        """Return all but the samples, from the events of its step."""
        own_events = [event for event in events if getattr(event, "recording", "") == self.name]
        starts = [e for e in own_events if isinstance(e, StepStarted)]
        # With a damaged end it is incomplete, even if its events say otherwise.
        ends = [e for e in own_events if isinstance(e, StepEnded) and not self.is_damaged]
        unstarted = StepStarted(
            seq=0,
            monotonic_s=0.0,
            utc="",
            step="",
            index=0,
            action="record",
            text="",
            recording=self.name,
        )
        start = starts[-1] if starts else unstarted
        return facts_of(self.number, self.shape, start, ends[-1] if ends else None)


def read_journal(files: RunFolder) -> Journal:
    """Read the journal of events; raise DataError if even its header is damaged."""
    headers: list[tuple[RunHeader, int]] = []
    plan, events = LongText(), StoredEvents()
    truth: dict[str, dict[str, float]] = {}
    end: int | None = None
    rows: Rows | None = None
    with reading(files.events):
        for record in read_records(files.events):
            end = record.end
            if record.kind in FROM:  # first, as nearly all are events
                event = events.take(record.kind, record.payload)
                rows = Rows(event) if isinstance(event, Scanned) else rows
            elif record.kind == Kind.PLAN:
                plan.packed.append(record.payload)
            elif record.kind == Kind.HEADER:
                headers.append(header_from(record.payload, str(files.events)))
            elif record.kind == Kind.ROW and rows is not None:
                events.take(*event_record(rows.event_from(record.payload)))
            elif record.kind == Kind.TRUTH:
                recording, values = truth_from(record.payload)
                truth[recording] = values
        lost = unread_bytes(files.events, end)
    if not headers:
        files_left = [*files.parts.glob("*.h5"), *files.journal.glob("*.samples")]
        hint = "nothing was recorded: remove the folder, and run the procedure again"
        if any(file.stat().st_size for file in files_left):
            hint = "samples were recorded: keep the folder, and restore its journal from a backup"
        raise DataError(
            f"{files.path} is not a run: its journal ends before the run's header", hint=hint
        )
    notes = (f"the last {lost} bytes of the journal are torn or damaged",) if lost else ()
    header, version = headers[0]
    define_units_of(header.provenance, header.run_id)
    answers = {a.into: a.text for a in events.outline if isinstance(a, Answer) and a.into}
    header = replace(
        header,
        inputs={**header.inputs, **answers},
        plan_text=plan if plan.packed else header.plan_text,
    )
    return Journal(header, events, truth, notes, end or 0, version)


def unfolded_journals(files: RunFolder) -> list[SampleJournal]:
    """Return the journals of samples that are not yet files of their own."""
    journals = (
        open_samples(path)
        for path in files.sample_journals()
        # After a kill before a folded journal was removed there are both, and the file counts.
        if not files.part(_number(path)).exists()
    )
    return [journal for journal in journals if journal is not None]


def _recordings(
    files: RunFolder, of_part: Callable[[Path], _T], of_samples: Callable[[SampleJournal], _T]
) -> Iterator[_T]:
    """Yield a value for each recording, in order, from its own file or else from its journal.

    Journals are listed first: if the recording process folds one meanwhile, its file exists before
    the journal is removed.
    """
    journals = {_number(path): path for path in files.sample_journals()}
    parts = {_number(path): path for path in files.finished_parts()}
    for number in sorted({*journals, *parts}):
        try:
            if number not in parts:
                if samples := open_samples(journals[number]):
                    yield of_samples(samples)
                continue
        except FileNotFoundError:
            pass  # it has become a file of its own
        yield of_part(files.part(number))


def open_samples(path: Path) -> SampleJournal | None:
    """Return a journal of samples; None if even its first block is damaged."""
    name, first, samples, end = "", None, 0, None
    for record in read_records(path):
        end = record.end
        if record.kind == Kind.BLOCK:
            name, block = block_from(record.payload)
            first, samples = first or block, samples + block.samples
    if first is None:
        return None
    shape = Shape(first.rate_hz, tuple(first.channels), samples)
    return SampleJournal(path, _number(path), name, shape, unread_bytes(path, end) > 0)


def read_loose(
    files: RunFolder, journal: Journal | None = None, *, samples: bool = True
) -> StoredRun:
    """Read a run that is not sealed, as far as it got; without `samples`, its description alone.

    `journal` is that of its events, if it has been read already.
    """
    journal = journal or read_journal(files)

    def read_samples(samples: SampleJournal) -> tuple[RecordingFacts, Recording, str]:
        facts = samples.facts(journal.events.outline)
        return facts, *assemble(facts, samples.blocks())

    with reading(files.path):
        read_part = partial(_read_part, scratch=None if _samples_fit(files) else Scratch())
        read = list(_recordings(files, read_part, read_samples)) if samples else []
    repeated = superseded(journal.events.outline)
    measured = journal.events.measured
    recorded = (recording for _, recording, _ in read)
    timed = with_elapsed(recorded, journal.events.outline, measured.began)
    recordings = [(facts, recording) for (facts, _, _), recording in zip(read, timed, strict=True)]
    complete = [(facts, recording) for facts, recording in recordings if facts.complete]
    return StoredRun(
        info=_info(files, journal, [(facts, digest) for facts, _, digest in read]),
        recordings=tuple(recording for facts, recording in complete if facts.name not in repeated),
        incomplete=tuple(recording for facts, recording in recordings if not facts.complete),
        superseded=tuple(recording for facts, recording in complete if facts.name in repeated),
        zeros=journal.zeros()[0],
        recording_zeros=zeros_in_force(journal.events.outline),
        measurements=measured.rows,
        superseded_measurements=measured.superseded,
        events=journal.events,
        outline=journal.events.outline,
        result_document=None,
        notes=journal.notes,
    )


def read_loose_info(files: RunFolder) -> RunInfo:
    """Read a run's description. Samples are read only from journals that are not yet folded."""
    journal = read_journal(files)

    def samples_facts(samples: SampleJournal) -> tuple[RecordingFacts, str]:
        facts = samples.facts(journal.events.outline)
        return facts, assemble(facts, samples.blocks())[1]

    with reading(files.path):
        return _info(files, journal, _recordings(files, _part_facts, samples_facts))


def _info(
    files: RunFolder,
    journal: Journal,
    pairs: Iterable[tuple[RecordingFacts, str]],
) -> RunInfo:
    repeated = superseded(journal.events.outline)
    counting = (pair for pair in pairs if pair[0].complete and pair[0].name not in repeated)
    finished = sorted(counting, key=lambda pair: pair[0].number)
    rows = journal.events.row_digests(journal.format)
    ended_utc, outcome, reason = journal.end()
    return RunInfo(
        path=files.path,
        sealed=False,
        header=journal.header,
        ended_utc=ended_utc,
        outcome=outcome,
        reason=reason,
        recording_names=tuple(facts.name for facts, _ in finished),
        digest=run_digest((digest for _, digest in finished), rows),
        format=journal.format,
    )


@contextmanager
def _open_part(part: Path) -> Iterator[h5py.Group]:
    with open_file(part) as file:
        for _ in objects(file):  # refuses what no run file has
            pass
        yield file[PART_GROUP]


def _part_facts(path: Path) -> tuple[RecordingFacts, str]:
    with _open_part(path) as group:
        return read_facts(group), str(group.attrs["sha256"])


def _samples_fit(files: RunFolder) -> bool:
    """Return whether the samples of the finished parts fit into memory."""
    total = 0
    for path in files.finished_parts():
        with open_file(path) as file:
            total += stored_bytes([file[PART_GROUP]])
    return total <= IN_MEMORY


def _read_part(path: Path, scratch: Scratch | None) -> tuple[RecordingFacts, Recording, str]:
    with _open_part(path) as group:
        return *read_recording(group, scratch), str(group.attrs["sha256"])


def _number(path: Path) -> int:
    return int(path.stem)


_FIXED = "<IdIq"
"""Number of the event, monotonic time, number of the point, milliseconds of UTC since 1970."""
_EPOCH, _MILLISECOND = datetime(1970, 1, 1, tzinfo=UTC), timedelta(milliseconds=1)


class Rows:
    """Points of a scan in a journal of the form before MessagePack.

    The first point was stored whole, and has what all have in common; the others are numbers alone.
    """

    def __init__(self, first: Scanned) -> None:
        self._first = first
        self._unpack = struct.Struct(f"{_FIXED}{len(first.setpoints) + len(first.values)}d").unpack

    def event_from(self, data: bytes) -> Scanned:
        """Return the point; raise DataError if it does not belong to this scan."""
        first = self._first
        try:
            seq, monotonic_s, point, milliseconds, *numbers = self._unpack(data)
            utc = utc_text(_EPOCH + milliseconds * _MILLISECOND)
        except (struct.error, OverflowError) as error:
            raise DataError(f"a record of the run is not a point of its scan: {error}") from error
        at = len(first.setpoints)
        return Scanned(
            seq=seq,
            monotonic_s=monotonic_s,
            utc=utc,
            step=first.step,
            point=point,
            measurement=first.measurement,
            setpoints=dict(zip(first.setpoints, numbers[:at], strict=True)),
            values=dict(zip(first.values, numbers[at:], strict=True)),
        )
