from __future__ import annotations

import errno
import os
import subprocess
import sys
from itertools import count

import h5py
import pytest

from helpers_devices import FakeTester, Listener, run
from rigrunner.api.errors import DataError
from rigrunner.api.events import (
    MadeSafe,
    Outcome,
    RunEnded,
    RunStarted,
    Scanned,
    StepEnded,
    StepStarted,
)
from rigrunner.runfile import RunWriter, read, read_truth, seal
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.journal import JournalWriter, Kind
from unit.runfile.helpers_runfile import (
    TWO,
    disk_full_beyond,
    emitter_of,
    end_recording,
    header_of,
    recording,
    send_samples,
    start_recording,
    write_run,
)


def test_engine_run_is_stored_completely(tmp_path):
    listener = Listener()
    with RunWriter(tmp_path / "run", header_of()) as writer:
        assert writer.recordings == 0
        run(FakeTester(), critical=[writer], guarded=[listener])
        assert writer.recordings == 2
        writer.seal()
    stored = read(tmp_path / "run")
    assert stored.info.outcome == "completed"
    assert stored.info.recording_names == ("001_10Hz", "002_20Hz")
    assert stored.header.inputs["specimen"] == "DEMO-0001"
    (zero,) = (event for event in listener.of(StepEnded) if event.action == "zero")
    assert stored.zeros == zero.values
    assert stored.recordings[1].conditions == {"tester.load": 1000.0}
    assert stored.recordings[1].setpoints == {"tester.load": 1000.0, "tester.frequency": 20.0}
    assert read_truth(tmp_path / "run")["002_20Hz"] == {"starting_torque_nm": 0.7262}


def test_sealing_reuses_what_was_read_for_the_analysis(tmp_path, monkeypatch):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        run(FakeTester(), critical=[writer])
        writer.close()
        stored_before, _ = writer.read_with_truth()
        monkeypatch.setattr("rigrunner.runfile.sealing.read_journal", None)
        writer.seal()
    stored = read(tmp_path / "run")
    assert (stored.digest, [*stored.events]) == (stored_before.digest, [*stored_before.events])
    assert read_truth(tmp_path / "run")["002_20Hz"] == {"starting_torque_nm": 0.7262}


def test_finished_recordings_become_files(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[0])
        send_samples(emit, TWO[0], 1000)
        end_recording(emit, TWO[0])
        writer.close()
        files = sorted(path.name for path in (tmp_path / "run").rglob("*.*"))
        assert files == ["000001.h5", "events.journal"]


def test_run_in_progress_can_be_read(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[0])
        send_samples(emit, TWO[0], 1000, until=2000)
        assert read(tmp_path / "run").incomplete[0].samples == 2000


@pytest.mark.parametrize("size", [100, 2_000, 20_000, 40_000])
def test_full_disk_keeps_finished_recordings(tmp_path, size):
    big = [recording(f"{number:03d}", samples=size // 16, seed=number) for number in range(3)]
    finished = 0
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        for index, original in enumerate(big[:2]):
            start_recording(emit, original, index)
            send_samples(emit, original, 10)
            end_recording(emit, original, index)
            finished += 1
        full = pytest.raises(DataError, match=r"cannot write .*free some space")
        with disk_full_beyond(size), full:
            start_recording(emit, big[2], 2)
            send_samples(emit, big[2], 10)
            end_recording(emit, big[2], 2)
    stored = read(tmp_path / "run")
    assert len(stored.recordings) >= finished
    assert [recording.name for recording in stored.recordings[:2]] == ["000", "001"]


def test_full_disk_ends_an_engine_run_safely(tmp_path):
    device = FakeTester()
    with RunWriter(tmp_path / "run", header_of()) as writer, disk_full_beyond(4_000):
        summary = run(device, critical=[writer])
    assert summary.outcome is Outcome.ERROR
    assert "free some space" in summary.reason
    assert summary.safe
    assert device.drives_at == {"load": 0.0, "frequency": 0.0}
    assert read(tmp_path / "run").info.outcome == "error"


def failing_once(number):
    """Return a JournalWriter.append that fails for one block, as on a full disk."""
    plain, calls = JournalWriter.append, count()

    def append(self, kind, *parts):
        if kind is Kind.BLOCK and next(calls) == number:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        plain(self, kind, *parts)

    return append


def test_run_that_cannot_store_samples_records_its_end(tmp_path, monkeypatch):
    monkeypatch.setattr(JournalWriter, "append", failing_once(1))
    with RunWriter(tmp_path / "run", header_of()) as writer:
        summary = run(FakeTester(), critical=writer.sinks)
    stored = read(tmp_path / "run")
    assert (stored.info.outcome, stored.info.reason) == ("error", summary.reason)
    assert "No space left on device" in summary.reason
    assert {event.what for event in stored.events if isinstance(event, MadeSafe)} == {"tester"}
    assert isinstance(stored.events[-1], RunEnded)
    assert stored.events[-1].resumable
    assert not stored.recordings
    (part,) = stored.incomplete
    assert part.samples > 0


def test_no_samples_are_stored_after_a_failed_block(tmp_path, monkeypatch):
    monkeypatch.setattr(JournalWriter, "append", failing_once(3))
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(*writer.sinks)
        start_recording(emit, TWO[1])
        with pytest.raises(DataError, match="No space left"):
            send_samples(emit, TWO[1], 1000)
        send_samples(emit, TWO[1], 1000)  # as in a teardown, which runs all the same
        end_recording(emit, TWO[1])
        start_recording(emit, TWO[0], 1)
        send_samples(emit, TWO[0], 1000)
        end_recording(emit, TWO[0], 1)
    stored = read(tmp_path / "run")
    assert [(recording.name, recording.samples) for recording in stored.incomplete] == [
        (TWO[1].name, 3000)
    ]
    assert [recording.name for recording in stored.recordings] == [TWO[0].name]


def test_sealing_on_a_full_disk_fails_and_can_be_repeated(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        run(FakeTester(), critical=[writer])
    with disk_full_beyond(20_000), pytest.raises(DataError, match="cannot write"):
        seal(tmp_path / "run")
    before = read(tmp_path / "run")
    assert len(before.recordings) == 2
    seal(tmp_path / "run")
    assert read(tmp_path / "run").digest == before.digest


@pytest.mark.parametrize("size", [0, 500, 3_000, 20_000, 50_000])
def test_full_disk_while_sealing_does_not_crash_the_process(tmp_path, size):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        run(FakeTester(), critical=[writer])
    program = f"""
import pathlib, resource, sys
from rigrunner.api.errors import DataError
from rigrunner.runfile import seal
resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, resource.RLIM_INFINITY))
try:
    seal(pathlib.Path(sys.argv[1]))
except DataError as error:
    sys.exit(error.exit_code)
"""
    ended = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "run")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (5, "")


def test_missing_folder_is_reported(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        (tmp_path / "run" / "journal").rename(tmp_path / "elsewhere")
        with pytest.raises(DataError, match=r"cannot write .*run"):
            start_recording(emit, TWO[0])


def test_journal_that_is_gone_after_the_run_is_reported(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        run(FakeTester(), critical=[writer])
        (tmp_path / "run" / "journal").rename(tmp_path / "elsewhere")
        for work in (writer.read_with_truth, writer.seal, lambda: read(tmp_path / "run")):
            with pytest.raises(DataError, match=r"run"):
                work()


@pytest.mark.parametrize(
    ("where", "name"), [(JournalWriter, "close"), (RunFolder, "sample_journals")]
)
def test_broken_disk_at_the_end_is_reported(tmp_path, monkeypatch, where, name):
    def fail(*_):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    with RunWriter(tmp_path / "run", header_of()) as writer:
        run(FakeTester(), critical=[writer])
        with monkeypatch.context() as patched:
            patched.setattr(where, name, fail)
            for work in (writer.seal, *((writer.read_with_truth,) if name != "close" else ())):
                with pytest.raises(DataError, match=r"run: Input/output error"):
                    work()


@pytest.mark.parametrize("measured", [True, False], ids=["measurement", "other step"])
@pytest.mark.parametrize("at_once", [True, False], ids=["each_measurement", "each_second"])
def test_measurement_is_synced_at_once_if_the_station_requires(
    tmp_path, monkeypatch, measured, at_once
):
    synced = []
    with RunWriter(tmp_path / "run", header_of(), sync_measurements=at_once) as writer:
        monkeypatch.setattr("os.fsync", synced.append)
        step = {"step": "main[0].measure", "index": 0, "action": "measure"}
        for _ in range(3):
            emitter_of(writer)(StepEnded, **step, ok=True, measurement="table" if measured else "")
        monkeypatch.undo()
    assert len(synced) == (3 if measured and at_once else 0)


def test_samples_before_their_step_are_refused(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        with pytest.raises(DataError, match="'001_10Hz' came outside of its step"):
            send_samples(emit, TWO[0], 100)


def test_recording_without_a_sample_is_refused(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[0])
        with pytest.raises(DataError, match="'001_10Hz' ended without a sample"):
            end_recording(emit, TWO[0])


def test_run_with_a_recording_without_a_sample_records_its_end(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(*writer.sinks)
        start_recording(emit, TWO[0])
        with pytest.raises(DataError, match="'001_10Hz' ended without a sample"):
            end_recording(emit, TWO[0])
        emit(RunEnded, outcome=Outcome.ERROR, reason="no sample")
    assert read(tmp_path / "run").info.reason == "no sample"


def test_existing_run_folder_is_refused(tmp_path):
    RunWriter(tmp_path / "run", header_of()).close()
    with pytest.raises(DataError, match="cannot write"):
        RunWriter(tmp_path / "run", header_of())


def test_run_resumed_before_any_recording_starts_with_number_one(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emitter_of(writer)(RunStarted, run_id="run", steps=1, estimated_s=1.0)
    with RunWriter(tmp_path / "run") as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[0])
        send_samples(emit, TWO[0], 1000)
        files = RunFolder(tmp_path / "run")
        assert files.sample_journals() == [files.samples(1)]


def test_only_recordings_count_when_a_run_is_resumed(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        emit(RunStarted, run_id="run", steps=3, estimated_s=1.0)
        for index, action in enumerate(("zero", "record")):  # without samples that are kept
            emit(StepStarted, step=f"main[{index}]", index=index, action=action, text="")
        start_recording(emit, TWO[0], 2)
    with RunWriter(tmp_path / "run") as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[1], 2)
        send_samples(emit, TWO[1], 1000)
        files = RunFolder(tmp_path / "run")
        assert files.sample_journals() == [files.samples(2)]


def test_small_blocks_are_joined_before_they_are_written(tmp_path, monkeypatch):
    """40,001 samples in blocks of 100 are three writes a column: two of 16,400 and the rest."""
    folder = tmp_path / "run"
    written, write = [], h5py.Dataset.__setitem__

    def recorder(dataset, where, values):
        if dataset.shape == (40_001,):
            written.append(len(values))
        write(dataset, where, values)

    monkeypatch.setattr(h5py.Dataset, "__setitem__", recorder)
    write_run(folder, [TWO[1]], block=100)
    seal(folder)
    columns = len(TWO[1].channels) + 1
    assert sorted(written) == sorted([16_400, 16_400, 7_201] * columns)


@pytest.mark.parametrize("kind", ["step", "point of a scan"])
def test_frequent_events_are_synced_within_a_second(tmp_path, monkeypatch, kind):
    now_s, synced_s = [0.0], []
    for module in ("journal", "writer"):
        monkeypatch.setattr(f"rigrunner.runfile.{module}.monotonic", lambda: now_s[0])
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        with monkeypatch.context() as patched:
            patched.setattr("os.fsync", lambda _: synced_s.append(now_s[0]))
            for tenth in range(31):
                now_s[0] = tenth / 10
                if kind == "step":
                    emit(StepEnded, step="main[0]", index=0, action="settle", ok=True)
                else:
                    values = {"tester.torque": 0.5 * tenth}
                    emit(
                        Scanned, step="main[0]", point=tenth, measurement="t", setpoints={},
                        values=values,
                    )  # fmt: skip
    assert synced_s == [1.1, 2.2]


def test_overlapping_recordings_have_separate_samples(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[0], 0)
        send_samples(emit, TWO[0], 1000, until=2000)
        start_recording(emit, TWO[1], 1)
        send_samples(emit, TWO[1], 1000)
        end_recording(emit, TWO[1], 1)
    stored = read(tmp_path / "run")
    (incomplete,), (complete,) = stored.incomplete, stored.recordings
    assert (incomplete.name, incomplete.samples) == (TWO[0].name, 2000)
    assert (complete.name, complete.samples) == (TWO[1].name, TWO[1].samples)


def test_samples_after_their_step_are_refused(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[0])
        send_samples(emit, TWO[0], 1000)
        end_recording(emit, TWO[0])
        with pytest.raises(DataError, match="came outside of its step"):
            send_samples(emit, TWO[0], 1000)
