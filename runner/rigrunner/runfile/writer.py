"""The critical sink that stores a run: journal first, then one durable file for each recording."""

from __future__ import annotations

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from time import monotonic
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

from rigrunner.api.cleanup import do_all, noted_on
from rigrunner.api.errors import DataError
from rigrunner.api.events import Event, RunEnded, Samples, Scanned, StepEnded, StepStarted
from rigrunner.runfile.codec import block_bytes, event_record, header_bytes, truth_bytes
from rigrunner.runfile.durable import cannot_write, sync_folder, writing
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.interrupts import uninterrupted
from rigrunner.runfile.journal import JournalWriter, Kind
from rigrunner.runfile.loose import SampleJournal, read_journal, read_loose
from rigrunner.runfile.recordings import Shape
from rigrunner.runfile.sealing import fold, seal

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from concurrent.futures import Future
    from pathlib import Path

    from rigrunner.api.details import RunPlot
    from rigrunner.api.events import EventSink
    from rigrunner.runfile.loose import Journal
    from rigrunner.runfile.model import RunHeader, StoredRun
    from rigrunner.runfile.reading import Truth


class RunWriter:
    """Stores the events of one run in its folder. Raises DataError if it cannot.

    After the event of a finished recording is accepted, the recording is on the disk: in its
    journal, which becomes an HDF5 file during the run.
    """

    def __init__(
        self, folder: Path, header: RunHeader | None = None, *, sync_measurements: bool = False
    ) -> None:
        """Create the journal of a new run, or without a header continue the existing one.

        The existing data stay unchanged; only a torn end of the journal is cut off.
        `sync_measurements`: each measurement is on the disk before the call returns, not within a
        second.
        """
        self._files = RunFolder(folder)
        self._sync_measurements = sync_measurements
        with writing(folder):
            if header is None:
                self._events, self._recordings = _reopen_journal(self._files)
            else:
                self._events, self._recordings = _create_journal(self._files, header), 0
        self._samples: JournalWriter | None = None
        self._shape: Shape | None = None
        self._started: StepStarted | None = None
        self._is_torn = False
        """Whether a block of the recording is missing: those after it are not stored."""
        self._failure: DataError | None = None
        self._read: Journal | None = None
        self._folding = Folding()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> None:
        if error is None:
            self.close()
        else:
            with noted_on(error, "closing the journal"):
                self.close()

    @property
    def folder(self) -> Path:
        """The run's folder."""
        return self._files.path

    @property
    def recordings(self) -> int:
        """The number of recordings that were begun."""
        return self._recordings

    @property
    def sinks(self) -> tuple[EventSink, EventSink]:
        """The writer as two critical sinks of a bus, one that stores and one that raises.

        A bus drops a sink that raises. As they are separate, the sink that stores remains after an
        error ends the run, for how the rig was made safe and how the run ended.
        """
        return self._keep, self._raise_failed

    def __call__(self, event: Event) -> None:
        """Store one event."""
        self._keep(event)
        self._raise_failed(event)

    def _keep(self, event: Event) -> None:
        try:
            match event:
                case Scanned():
                    self._append_soon(event, at_once=self._sync_measurements)
                case StepStarted() | StepEnded() if not event.recording:
                    measured = isinstance(event, StepEnded) and bool(event.measurement)
                    self._append_soon(event, at_once=self._sync_measurements and measured)
                case StepStarted():
                    self._close_samples()
                    self._append(event)
                    self._recordings += 1
                    self._started, self._is_torn = event, False
                case StepEnded():
                    self._end_recording(event)
                case Samples() if event.recording:
                    self._take_samples(event)
                case Samples():
                    pass  # not to be kept
                case _:
                    self._append(event)
        # Raised by the other sink: this one has to store what follows.
        except DataError as error:
            self._failure = error
        except OSError as error:  # of a journal, which takes back what it could not write whole
            self._failure = cannot_write(self.folder, error)
            self._failure.__cause__ = error

    def _raise_failed(self, event: Event) -> None:
        """Raise the error of a write, or of a fold."""
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure
        # A failed fold is repeated at sealing: it must not contradict an end that is stored.
        if self._folding.pending and not isinstance(event, RunEnded):
            self._folding.check()

    def read_with_truth(self) -> tuple[StoredRun, Truth]:
        """Read the run, which must be closed; `seal` then writes what was read."""
        self._read = read_journal(self._files)
        return read_loose(self._files, self._read), self._read.truth

    def seal(
        self,
        result_document: Mapping[str, Any] | None = None,
        plot: RunPlot | None = None,
        partners: Mapping[str, Path] = MappingProxyType({}),
    ) -> Path:
        """Close the journal and write `run.h5`; see `rigrunner.runfile.seal`."""
        with uninterrupted():
            self.close()
            journal, self._read = self._read, None
            return seal(self.folder, result_document, plot, partners, journal=journal)

    def close(self) -> None:
        """Close the journal after all folds; the folder stays readable. Idempotent."""
        with writing(self.folder):
            do_all(self._close_samples, self._events.close, self._folding.wait)

    def _append(self, event: Event) -> None:
        self._events.append(*event_record(event))
        self._events.sync()

    def _append_soon(self, event: Event, *, at_once: bool) -> None:
        """Append an event that may come thousands of times per second: on the disk within a second.

        With `at_once`, it is on the disk on return.
        """
        self._events.append(*event_record(event))
        if at_once or monotonic() > self._events.sync_due_s:
            self._events.sync()

    def _take_samples(self, event: Samples) -> None:
        if self._started is None or self._started.recording != event.recording:
            raise DataError(f"samples of '{event.recording}' came outside of its step")
        if self._is_torn:
            return
        self._is_torn = True  # until this block is kept
        block = event.block
        if self._samples is None:
            self._samples = JournalWriter(self._files.samples(self._recordings))
            self._shape = Shape(block.rate_hz, tuple(block.channels), 0)
        assert self._shape is not None  # noqa: S101  (made with the journal)
        self._samples.append(Kind.BLOCK, *block_bytes(event.recording, block))
        self._shape = replace(self._shape, samples=self._shape.samples + block.samples)
        self._samples.sync_sometimes()
        self._is_torn = False

    def _end_recording(self, event: StepEnded) -> None:
        # Synced before its end is stored: a recording that has ended is whole on the disk.
        started, shape, samples = self._started, self._shape, self._close_samples()
        self._started = None
        if self._is_torn and event.ok:
            return  # without its end it counts as interrupted
        if event.truth:
            self._events.append(Kind.TRUTH, truth_bytes(event.recording, event.truth))
        self._append(event)
        if not event.ok:
            return
        if samples is None or shape is None or started is None:
            raise DataError(f"recording '{event.recording}' ended without a sample")
        journal = SampleJournal(samples, self._recordings, event.recording, shape)
        self._folding.start(partial(fold, self._files, journal, (started, event)))

    def _close_samples(self) -> Path | None:
        """Close the journal of samples, durably and under its name; return its path."""
        if self._samples is None:
            return None
        journal, self._samples, self._shape = self._samples, None, None
        try:
            journal.sync()
        finally:
            journal.close()
        sync_folder(journal.path.parent)
        return journal.path


def _create_journal(files: RunFolder, header: RunHeader) -> JournalWriter:
    """Return the journal of a new run."""
    files.journal.mkdir(parents=True)
    events = JournalWriter(files.events)
    for part in header.plan_text.packed:
        events.append(Kind.PLAN, part)
    events.append(Kind.HEADER, header_bytes(header))
    events.sync()
    # The folder of the run is new as well: its name has to be on the disk too.
    for path in (files.journal, files.path, files.path.parent):
        sync_folder(path)
    return events


def _reopen_journal(files: RunFolder) -> tuple[JournalWriter, int]:
    """Return the journal of an interrupted run, and the number of its last recording."""
    journal = read_journal(files)
    # Both: a recording may have no samples yet, or have lost its start with a torn end.
    begun_count = sum(
        isinstance(event, StepStarted) and bool(event.recording) for event in journal.events.outline
    )
    numbers = [int(path.stem) for path in (*files.sample_journals(), *files.finished_parts())]
    events = JournalWriter(files.events, journal.records_end)
    events.sync()
    return events, max(begun_count, *numbers, 0)


class Folding:
    """Folds one recording after the other in a thread; the process waits for it at its end.

    HDF5 compresses without the interpreter's lock, so the recording thread continues. Only names
    are queued; the samples stay on the disk, in complete and synced journals.
    """

    def __init__(self) -> None:
        self._worker = ThreadPoolExecutor(1, "fold")
        self.pending: deque[Future[None]] = deque()
        """Folds that were started and not yet checked."""

    def start(self, fold: Callable[[], None]) -> None:
        """Start a fold, which begins after those before it."""
        self.pending.append(self._worker.submit(fold))

    def check(self) -> None:
        """Raise the error of a failed fold. Its recording is still complete, in its journal."""
        while self.pending and self.pending[0].done():
            self.pending.popleft().result()

    def wait(self) -> None:
        """Wait until all are done. Failed ones are repeated at sealing. Idempotent."""
        self._worker.shutdown()
