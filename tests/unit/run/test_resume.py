from __future__ import annotations

import json
import shutil
import threading
from dataclasses import replace

import h5py
import pytest

from e2e.helpers_resume import Snapshot, interrupted, interrupted_at, resumable, resume_run
from helpers_tester import FREQUENCIES, procedure_file, run, station_file
from rigrunner.api.errors import DataError, DeviceLostError, ExitCode, UsageError
from rigrunner.api.events import (
    RESUME_RUN,
    Intervention,
    Outcome,
    RunEnded,
    Samples,
    StepEnded,
    StepStarted,
)
from rigrunner.documents.verifying.run import verify_run
from rigrunner.engine import UnattendedAnswers
from rigrunner.registry import load_registry
from rigrunner.run import provenance
from rigrunner.run.interrupted import recover
from rigrunner.run.resume import resume, run_files
from rigrunner.run.runs import list_runs
from rigrunner.run.stored import open_run
from rigrunner.runfile import NEVER_ENDED, is_in_progress, read, run_lock
from rigrunner.runfile.sealing import fold

pytestmark = pytest.mark.usefixtures("tester")
TWICE = (FREQUENCIES, "[8 Hz, 15 Hz, 15 Hz, 25 Hz, 35 Hz]")
"""A repeated set-point, whose noise must differ the second time."""


def files(folder, *changes):
    """Write the procedure without load, with changes, and the station."""
    return {
        "procedure": procedure_file(folder, "idle", *changes),
        "station": station_file(folder),
    }


def in_recording(prefix):
    return lambda event: isinstance(event, Samples) and event.recording.startswith(prefix)


def document(finished):
    return json.loads((finished.folder / "result.json").read_text(encoding="utf-8"))


def numbers(content):
    """Return all numbers of a result document by place, without those of the files themselves."""
    paths = {}

    def walk(value, path):
        if isinstance(value, dict):
            for name, item in value.items():
                walk(item, (*path, name))
        elif isinstance(value, list):
            for index, item in enumerate(value):
                walk(item, (*path, index))
        elif isinstance(value, float):
            paths[path] = value

    walk(content, ())
    return paths


@pytest.fixture(scope="module")
def origin(tmp_path_factory):
    folder = tmp_path_factory.mktemp("second")
    return interrupted(folder, in_recording("002"), **files(folder))[0]


@pytest.fixture
def killed(origin, tmp_path):
    """Return a copy of a run that was interrupted in its second recording."""
    folder = tmp_path / "killed" / origin.name
    shutil.copytree(origin, folder)
    return folder


def changed(origin, tmp_path, name, old, new):
    """Return a copy of one of the files of the run, with a text replaced."""
    text = (origin.parent.parent / name).read_text(encoding="utf-8")
    assert old in text
    (tmp_path / name).write_text(text.replace(old, new), encoding="utf-8")
    return tmp_path / name


@pytest.fixture(scope="module")
def third(tmp_path_factory):
    """Return a run interrupted in its third recording, the same uninterrupted, and resumed."""
    folder = tmp_path_factory.mktemp("resume")
    killed, reference = interrupted(folder, in_recording("003"), **files(folder, TWICE))
    before = read(killed)
    return before, reference, resume_run(killed)


def test_resumed_run_has_results_of_uninterrupted_run(third):
    _, reference, resumed = third
    assert resumed.outcome is Outcome.COMPLETED
    actual, expected = (numbers(without_zeros(document(run))) for run in (resumed, reference))
    assert actual == expected
    assert len(expected) > 40


def without_zeros(content):
    """Return a result document without the errors of zeros, and what they are a part of.

    A resumed run has two zeros: two errors, each of some of the values.
    """
    for result in content["results"]:
        result["estimate"] = {"value": result["estimate"]["value"]}
        result["budget"] = [line for line in result["budget"] if "zero" not in line["name"]]
        for line in result["budget"]:
            del line["share"]
    return content


def test_finished_recordings_are_not_repeated(third):
    before, reference, resumed = third
    after = read(resumed.folder)
    assert [recording.name for recording in before.recordings] == ["001_8Hz", "002_15Hz"]
    names = [recording.name for recording in after.recordings]
    assert names == ["001_8Hz", "002_15Hz", "003_15Hz_try2", "004_25Hz", "005_35Hz"]
    (part,) = after.incomplete
    assert part.name == "003_15Hz"
    assert part.samples == before.incomplete[0].samples > 0
    for mine, other in zip(after.recordings, read(reference.folder).recordings, strict=True):
        for channel, values in other.channels.items():
            assert (mine.channels[channel] == values).all(), (mine.name, channel)


def test_resumption_is_recorded_with_time_person_and_recordings(third):
    before, _, resumed = third
    events = read(resumed.folder).events
    assert [event.seq for event in events if event.seq >= 0] == sorted(e.seq for e in events)
    (resume_at,) = (e for e in events if isinstance(e, Intervention) and e.action == RESUME_RUN)
    assert resume_at.by == "A. Jones"
    assert "001_8Hz, 002_15Hz" in resume_at.subject
    assert before.info.ended_utc in resume_at.subject
    with h5py.File(resumed.folder / "run.h5") as file:
        recordings = [*file["entry/recordings"].values(), *file["entry/incomplete"].values()]
        parts = {recording.attrs["name"]: int(recording.attrs["part"]) for recording in recordings}
    assert parts == {
        "001_8Hz": 1, "002_15Hz": 1, "003_15Hz": 1, "003_15Hz_try2": 2, "004_25Hz": 2, "005_35Hz": 2
    }  # fmt: skip


def test_resumed_run_verifies(third):
    _, _, resumed = third
    verification = verify_run(resumed.folder, load_registry())
    assert verification.matches, verification


def test_setup_and_zero_are_repeated_and_recordings_keep_their_zero(killed):
    resumed = resume_run(killed)
    events = read(resumed.folder).events
    zeros = [e.values for e in events if isinstance(e, StepEnded) and e.action == "zero"]
    assert len(zeros) == 2
    data = open_run(resumed.folder).data
    for number, (recording, read_before) in enumerate(
        zip(("001_8Hz", "005_35Hz"), zeros, strict=True), start=1
    ):
        in_force = data.recording_zeros[recording]
        assert {name: zero.value for name, zero in in_force.items()} == read_before
        assert {zero.number for zero in in_force.values()} == {number}
    assert [e.action for e in events if isinstance(e, StepEnded)].count("confirm") == 2


def at_end(event):
    return isinstance(event, RunEnded)


INSTANTS = {
    "setup": lambda e: isinstance(e, StepStarted) and e.action == "confirm",
    "zeroed": lambda e: isinstance(e, StepEnded) and e.action == "zero",
    "first": in_recording("001"),
    "between": lambda e: isinstance(e, StepEnded) and e.recording.startswith("002"),
    "last": lambda e: isinstance(e, StepEnded) and e.recording.startswith("005"),
    "teardown": lambda e: isinstance(e, StepStarted) and e.step.startswith("teardown"),
    "ended": at_end,
}


@pytest.fixture(scope="module")
def everywhere(tmp_path_factory):
    folder = tmp_path_factory.mktemp("everywhere")
    return interrupted_at(folder, INSTANTS.values(), **files(folder))


@pytest.mark.parametrize("instant", INSTANTS)
def test_run_can_be_resumed_at_any_instant(everywhere, instant):
    folders, reference = everywhere
    killed = folders[list(INSTANTS).index(instant)]
    resumed = resume_run(killed)
    assert resumed.outcome is Outcome.COMPLETED
    assert resumed.exit_code is ExitCode.PASS
    after, uninterrupted = read(resumed.folder), read(reference.folder)
    assert len(after.recordings) == len(uninterrupted.recordings) == 5
    assert after.info.sealed
    assert resumed.report.exists()
    names = [recording.name.partition("_try")[0] for recording in after.recordings]
    assert names == [recording.name for recording in uninterrupted.recordings]


def test_run_can_be_interrupted_repeatedly(killed, tmp_path):
    second = Snapshot(killed.parent, tmp_path / "again", in_recording("004"))
    resume_run(killed, listeners=[second])
    resumed = resume_run(second.folder, by="B. Smith")
    events = read(resumed.folder).events
    assert [e.by for e in events if isinstance(e, Intervention)] == ["A. Jones", "B. Smith"]
    data = open_run(resumed.folder).data
    assert len(data.recordings) == 5
    assert len(data.recording_zeros) == 5


def test_changed_procedure_is_refused_with_difference(killed, origin, tmp_path):
    file = changed(origin, tmp_path, "idle.yaml", "15 Hz", "16 Hz")
    with pytest.raises(DataError, match=r"the procedure in line \d+ was '.*15 Hz.*', is '.*16 Hz"):
        resumable(killed, procedure=file)


def test_changed_station_is_refused_with_difference(killed, origin, tmp_path):
    file = changed(origin, tmp_path, "station.yaml", "{seed: 1}", "{seed: 2}")
    with pytest.raises(DataError, match=r"the station in line \d+ was '.*seed: 1.*seed: 2"):
        resumable(killed, station=file)


def test_plugins_of_stored_station_are_not_run_without_consent(killed, origin, tmp_path):
    file = changed(origin, tmp_path, "station.yaml", "devices:\n", "plugins: plugins\n\ndevices:\n")
    stored = with_files(read(killed), station=file)
    with pytest.raises(UsageError, match="plugins of its own") as caught:
        run_files(stored, None, None)
    assert f"--station {file}" in caught.value.hint


def test_other_package_version_is_refused(killed, monkeypatch):
    monkeypatch.setattr(provenance, "version", lambda name: "0.0" if name == "numpy" else "1")
    with pytest.raises(DataError, match=r"numpy was [\d.]+, is 0\.0"):
        resumable(killed)


def test_other_instrument_is_refused_and_journal_is_unchanged(killed):
    journal = killed / "journal" / "events.journal"
    run = resumable(killed)
    provenance = {**run.stored.header.provenance, "device tester": "ACME tester 7"}
    info = run.stored.info
    info = replace(info, header=replace(info.header, provenance=provenance))
    run = replace(run, stored=replace(run.stored, info=info))
    before = journal.read_bytes()
    with pytest.raises(DataError, match="device tester was ACME tester 7, is Tests"):
        resume(run, answers=UnattendedAnswers(), stop=threading.Event())
    assert journal.read_bytes() == before


def with_files(stored, **files):
    """Return a run that names other files."""
    header = stored.header
    paths = {**header.files, **{name: str(path) for name, path in files.items()}}
    return replace(stored, info=replace(stored.info, header=replace(header, files=paths)))


def test_moved_file_must_be_named(killed, tmp_path):
    stored = with_files(read(killed), procedure=tmp_path / "moved.yaml")
    with pytest.raises(UsageError, match="no longer exists") as caught:
        run_files(stored, None, None)
    assert "--procedure FILE" in caught.value.hint


def test_run_in_progress_is_neither_resumed_nor_recovered(killed):
    with run_lock(killed):
        assert is_in_progress(killed)
        with pytest.raises(DataError, match="still running"):
            resume_run(killed)
        with pytest.raises(DataError, match="still running"):
            recover(killed, resumable(killed).planned.clock, "A. Jones")
    assert not is_in_progress(killed)
    assert not read(killed).info.sealed


def test_run_locks_its_folder_until_sealed(tmp_path):
    states = []

    def look(event):
        states.append((is_in_progress(next((tmp_path / "runs").iterdir())), type(event)))
        return isinstance(event, RunEnded)

    _, reference = interrupted(tmp_path, look, **files(tmp_path))
    assert {locked for locked, _ in states} == {True}
    assert not (reference.folder / "run.lock").exists()


def test_recover_seals_run_as_it_is(killed):
    before = read(killed)
    stored = recover(killed, resumable(killed).planned.clock, "A. Jones", "the bearing seized")
    assert stored.info.sealed
    assert stored.info.outcome == "aborted"
    assert "A. Jones: the bearing seized" in stored.info.reason
    assert stored.digest == before.digest
    samples = [part.samples for part in before.incomplete]
    assert [part.samples for part in stored.incomplete] == samples
    assert verify_run(killed, load_registry()).matches
    with pytest.raises(DataError, match="has ended and is sealed"):
        recover(killed, resumable, "A. Jones")


def test_recover_keeps_outcome_of_ended_run(tmp_path):
    killed, _ = interrupted(tmp_path, at_end, **files(tmp_path))
    stored = recover(killed, None, "A. Jones")
    assert stored.info.outcome == "completed"
    assert stored.info.sealed


@pytest.fixture
def unfolded(tmp_path, monkeypatch):
    """Return a run whose second recording could not be folded, neither at once nor at sealing."""
    failed = threading.Event()

    def full(files, samples, step):
        if samples.number == 2:
            failed.set()
            raise DataError("cannot write 000002.h5: No space left on device")
        fold(files, samples, step)

    def wait(event):
        assert not in_recording("003")(event) or failed.wait(30)

    procedure = procedure_file(tmp_path, "idle")
    with monkeypatch.context() as disk:
        disk.setattr("rigrunner.runfile.writer.fold", full)
        disk.setattr("rigrunner.runfile.sealing.fold", full)
        ended = run(procedure, tmp_path / "runs", listeners=[wait])
    assert (ended.outcome, ended.sealed) == (Outcome.ERROR, False)
    return ended.folder


def test_run_with_unfolded_recording_resumes_and_keeps_former_end(unfolded, tmp_path):
    (listed,) = list_runs(unfolded.parent)
    assert (listed.state, listed.is_interrupted) == ("error, not sealed", True)
    again = Snapshot(unfolded.parent, tmp_path / "again", in_recording("005"))
    resumed = resume_run(unfolded, listeners=[again])
    assert resumed.outcome is Outcome.COMPLETED
    stored = read(resumed.folder)
    assert len(stored.recordings) == 5
    former = next(event for event in stored.events if isinstance(event, RunEnded))
    assert "No space left" in former.reason
    assert former.read_back["tester.load"] == 0.0
    resume_at = next(event for event in stored.events if isinstance(event, Intervention))
    assert "No space left" in resume_at.subject
    assert verify_run(resumed.folder, load_registry()).matches

    killed = read(again.folder)  # the former end no longer counts
    assert (killed.info.outcome, killed.info.reason) == ("error", NEVER_ENDED)
    assert resumable(again.folder).resume_at is not None


def test_recover_keeps_reason_of_run_that_could_not_be_stored(unfolded):
    stored = recover(unfolded, None, "A. Jones")
    assert (stored.info.sealed, stored.info.outcome) == (True, "error")
    assert "No space left" in stored.info.reason
    assert [recording.name for recording in stored.recordings] == ["001_8Hz", "002_15Hz"]


def test_run_that_lost_a_device_is_resumed_to_its_end(tmp_path):
    """The interrupted set-point is recorded again, the others are kept."""
    fault = "{plugin: tester_of_tests, settings: {seed: 1}, faults: [%s]}"
    station = station_file(
        tmp_path,
        ("plugin: tester_of_tests", "plugin: fault"),
        ("settings: {seed: 1}", f"settings: {fault % '{kind: lost, on: stream, calls: [5]}'}"),
    )
    ended = run(procedure_file(tmp_path, "idle"), tmp_path / "runs", station=station)
    assert isinstance(ended.error, DeviceLostError)
    assert not ended.sealed
    before = read(ended.folder)
    assert before.events[-1].resumable
    names = [recording.name for recording in before.recordings]
    assert len(names) == 3
    (listed,) = list_runs(ended.folder.parent)
    assert listed.is_interrupted

    resumed = resume_run(ended.folder)
    assert (resumed.outcome, resumed.sealed) == (Outcome.COMPLETED, True)
    after = read(resumed.folder)
    assert len(after.recordings) == 5
    for earlier in before.recordings:
        later = next(recording for recording in after.recordings if recording.name == earlier.name)
        assert later.samples == earlier.samples
    former = next(event for event in after.events if isinstance(event, RunEnded))
    assert former.outcome is Outcome.ERROR
