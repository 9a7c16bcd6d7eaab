"""Recordings are folded in the background: no step waits for it and nothing is lost."""

from __future__ import annotations

import os
import signal
import threading
from concurrent.futures import wait
from pathlib import Path

import pytest

from helpers_devices import FakeTester, run
from rigrunner.api.errors import DataError
from rigrunner.api.events import MadeSafe, Outcome, RunEnded, StepEnded
from rigrunner.runfile import RunWriter, loose, read, seal, sealing
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.journal import JournalWriter, Kind
from rigrunner.runfile.writer import Folding
from unit.runfile.helpers_runfile import (
    TWO,
    assert_same_recording,
    emitter_of,
    end_recording,
    header_of,
    send_samples,
    start_recording,
)

FOLD = "rigrunner.runfile.writer.fold"


def emit_recording(emit, original, index=0):
    start_recording(emit, original, index)
    send_samples(emit, original, 1000)
    end_recording(emit, original, index)


@pytest.fixture
def folding(monkeypatch):
    """Return the event that releases folds; until it is set, each one waits."""
    go_on = threading.Event()

    def fold(*what):
        assert go_on.wait(30)
        sealing.fold(*what)

    monkeypatch.setattr(FOLD, fold)
    yield go_on
    go_on.set()


def test_steps_do_not_wait_for_folds(tmp_path, folding):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        for index, original in enumerate(TWO):
            emit_recording(emit, original, index)
        before = read(tmp_path / "run")
        folding.set()
    assert not before.incomplete
    after = read(tmp_path / "run")
    for stored_run in (before, after):
        for stored, original in zip(stored_run.recordings, TWO, strict=True):
            assert_same_recording(stored, original)
    assert before.digest == after.digest
    assert [path.name for path in RunFolder(tmp_path / "run").finished_parts()] == [
        "000001.h5",
        "000002.h5",
    ]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="paths of descriptors are those of Linux")
def test_recording_is_synced_before_its_step_ends(tmp_path, monkeypatch):
    synced, when_ended = [], []
    plain_sync, plain_append = os.fsync, JournalWriter.append

    def fsync(descriptor):
        plain_sync(descriptor)
        path = Path(f"/proc/self/fd/{descriptor}").readlink()
        synced.append((path, os.fstat(descriptor).st_size))

    def append(self, kind, *parts):
        if kind is Kind.PACKED and StepEnded.__name__.encode() in b"".join(map(bytes, parts)):
            when_ended.append(tuple(synced))
        plain_append(self, kind, *parts)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(JournalWriter, "append", append)
    monkeypatch.setattr(FOLD, lambda *_: None)
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit_recording(emitter_of(writer), TWO[1])
    samples = RunFolder(tmp_path / "run").samples(1)
    (files,) = when_ended
    assert files[-2] == (samples, samples.stat().st_size)
    assert files[-1][0] == samples.parent  # only then is the name of the new file durable
    assert samples.stat().st_size > 16 * TWO[1].samples


def test_failed_fold_is_reported_and_repeated_at_sealing(tmp_path, monkeypatch):
    done = threading.Event()

    def full(*_):
        done.set()
        raise DataError("cannot write 000001.h5: No space left on device")

    monkeypatch.setattr(FOLD, full)
    with RunWriter(tmp_path / "run", header_of()) as writer:
        summary = run(
            FakeTester(before=lambda call: done.wait(10) if call == "set frequency 20" else None),
            critical=writer.sinks,
        )
        assert (summary.outcome, summary.safe) == (Outcome.ERROR, True)
        assert "No space left" in summary.reason
        writer.seal()
    stored = read(tmp_path / "run")
    assert [recording.name for recording in stored.recordings] == ["001_10Hz"]
    assert (stored.info.outcome, stored.info.reason) == ("error", summary.reason)
    assert any(isinstance(event, MadeSafe) for event in stored.events)


def test_interrupt_during_sealing_leaves_a_sealed_run(tmp_path, monkeypatch):
    waits = threading.Event()

    def fold(*what):
        assert waits.wait(30)
        sealing.fold(*what)
        signal.raise_signal(signal.SIGINT)

    def close(self):
        waits.set()
        plain(self)

    plain = RunWriter.close
    monkeypatch.setattr(FOLD, fold)
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit_recording(emitter_of(writer), TWO[1])
        monkeypatch.setattr(RunWriter, "close", close)
        with pytest.raises(KeyboardInterrupt):
            writer.seal()
    assert RunFolder(tmp_path / "run").sealed_file.exists()
    assert_same_recording(read(tmp_path / "run").recordings[0], TWO[1])


def test_recording_folded_while_read_is_still_read(tmp_path, monkeypatch):
    folder = tmp_path / "run"
    with RunWriter(folder, header_of()) as writer, monkeypatch.context() as patched:
        patched.setattr(FOLD, lambda *_: None)
        for index, original in enumerate(TWO):
            emit_recording(emitter_of(writer), original, index)
    plain, events = loose.open_samples, loose.read_journal(RunFolder(folder)).events

    def opened(path):
        sealing.fold(RunFolder(folder), plain(path), events)
        return plain(path)

    monkeypatch.setattr(loose, "open_samples", opened)
    for stored, original in zip(read(folder).recordings, TWO, strict=True):
        assert_same_recording(stored, original)


def test_finished_recording_with_damaged_journal_is_incomplete(tmp_path, monkeypatch):
    folder = tmp_path / "run"
    with RunWriter(folder, header_of()) as writer, monkeypatch.context() as patched:
        patched.setattr(FOLD, lambda *_: None)
        emit_recording(emitter_of(writer), TWO[1])
    samples = RunFolder(folder).samples(1)
    content = bytearray(samples.read_bytes())
    content[len(content) // 2] ^= 1
    samples.write_bytes(content)
    seal(folder)
    stored = read(folder)
    assert not stored.recordings
    (part,) = stored.incomplete
    assert 0 < part.samples < TWO[1].samples


def test_damaged_journal_is_reported_and_kept(tmp_path, folding):
    folder = tmp_path / "run"
    with RunWriter(folder, header_of()) as writer:
        emit = emitter_of(writer)
        emit_recording(emit, TWO[1])
        samples = RunFolder(folder).samples(1)
        content = bytearray(samples.read_bytes())
        content[len(content) // 2] ^= 1
        samples.write_bytes(content)
        folding.set()
        wait(writer._folding.pending)
        with pytest.raises(DataError, match=r"samples can be read back, not 40001"):
            start_recording(emit, TWO[0], 1)
    assert samples.exists()
    assert not RunFolder(folder).finished_parts()


def test_fold_in_a_deleted_folder_is_reported_with_its_remedy(tmp_path, folding):
    folder = tmp_path / "run"
    with RunWriter(folder, header_of()) as writer:
        emit_recording(emitter_of(writer), TWO[1])
        folder.rename(tmp_path / "moved")
        folding.set()
        with pytest.raises(DataError, match="recordings: No such file") as refused:
            writer._folding.pending[0].result(30)
    assert "was it deleted or moved" in refused.value.hint


def test_folds_do_not_overlap():
    """Two at once would take twice the memory, and a processor from the recording thread."""
    second = threading.Event()
    overlapped = []
    folding = Folding()
    folding.start(lambda: overlapped.append(second.wait(0.5)))
    folding.start(second.set)
    folding.wait()
    assert second.is_set()
    assert overlapped == [False]


def test_fold_that_fails_at_the_end_is_repeated_at_sealing(tmp_path, monkeypatch):
    """A stored end stays true: its event is not refused for an earlier recording."""
    go_on = threading.Event()

    def fail(*_):
        assert go_on.wait(30)
        raise DataError("cannot write 000001.h5: Input/output error")

    monkeypatch.setattr(FOLD, fail)
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(*writer.sinks)
        emit_recording(emit, TWO[0])
        go_on.set()
        wait(writer._folding.pending)
        emit(RunEnded, outcome=Outcome.COMPLETED, reason="")
        writer.seal()
    stored = read(tmp_path / "run")
    assert stored.info.outcome == Outcome.COMPLETED
    assert [recording.name for recording in stored.recordings] == [TWO[0].name]
