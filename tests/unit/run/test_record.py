import errno
import json
import signal
import threading
from dataclasses import replace
from pathlib import Path

import h5py
import pytest

from helpers_figures import drawn
from helpers_workflow import START, quick_procedure, run, station_file
from rigrunner.analysis.analyse import analyse
from rigrunner.analysis.document import document
from rigrunner.api.errors import (
    AbortedError,
    DataError,
    DeviceLostError,
    DeviceNotFoundError,
    ExitCode,
)
from rigrunner.api.events import Outcome, RunEnded, StepStarted
from rigrunner.api.progress import unseen
from rigrunner.cli.finishing import show_finished
from rigrunner.cli.stopping import stop_on_signals
from rigrunner.clock import SimulatedClock
from rigrunner.procedure import parse_procedure
from rigrunner.registry import load_registry
from rigrunner.rig import Rig
from rigrunner.run import finish
from rigrunner.run.finish import _write_result
from rigrunner.run.report import AnalysedRun, report_input, write_report
from rigrunner.run.stored import analyse_run, analyse_stored, open_run
from rigrunner.runfile import read, read_with_truth
from rigrunner_bearings.api.torque import TorqueDetails


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Return a quick no-load run and a quick loaded run: (folder, no-load, loaded)."""
    folder = tmp_path_factory.mktemp("finished")
    clock = SimulatedClock(START)
    no_load = run(quick_procedure(folder, "no_load_inertia_sweep"), folder / "runs", clock=clock)
    with drawn():
        loaded = run(quick_procedure(folder, "starting_torque_1000n"), folder / "runs", clock=clock)
    return folder, no_load, loaded


def test_run_leaves_sealed_folder_with_result_report_and_log(finished):
    _, _, loaded = finished
    assert loaded.outcome is Outcome.COMPLETED
    assert loaded.exit_code is ExitCode.PASS
    names = {path.name for path in loaded.folder.iterdir()}
    assert names == {"run.h5", "result.json", "report.html", "run.log"}
    assert (loaded.folder / "run.h5").stat().st_mode & 0o222 == 0


def test_failed_write_of_result_keeps_previous_file(tmp_path, monkeypatch):
    (tmp_path / "result.json").write_text("{}", encoding="utf-8")
    write = Path.write_bytes

    def write_half(path, content):
        write(path, content[:10])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", write_half)
    monkeypatch.setattr(Path, "write_text", lambda path, text, **_: write_half(path, text.encode()))
    with pytest.raises(DataError, match="No space left on device"):
        _write_result(tmp_path, {"rigrunner": "result/1", "verdict": "PASS"})
    assert [path.name for path in tmp_path.iterdir()] == ["result.json"]
    assert (tmp_path / "result.json").read_bytes() == b"{}"


def test_result_is_near_true_value_of_simulator(finished):
    _, _, loaded = finished
    headline = loaded.result.headline
    assert headline.value == pytest.approx(0.7262, abs=0.012)
    assert TorqueDetails.of(loaded.result).raw_headline.value > 2.0


def test_online_stored_and_library_analysis_agree_to_the_last_digit(finished):
    _, no_load, loaded = finished
    online = json.loads((loaded.folder / "result.json").read_text())
    registry = load_registry()
    stored = read(loaded.folder)
    assert stored.result_document == online
    assert document(analyse_run(loaded.folder, registry)) == online
    assert document(analyse_run(loaded.folder, registry, {"no_load": no_load.folder})) == online
    procedure = parse_procedure(stored.header.procedure_text, "stored").model
    partners = {"no_load": open_run(no_load.folder).data}
    library_result = analyse(
        replace(open_run(loaded.folder).data, partners=partners),
        procedure.analysis,
        acceptance=procedure.acceptance,
        measurand=procedure.measurand,
        lookup=registry,
    )
    assert json.loads(json.dumps(document(library_result))) == online


def test_analysis_never_gets_the_truth(finished):
    _, _, loaded = finished
    data = open_run(loaded.folder).data
    names = [*data.zeros, *data.inputs]
    for recording in data.recordings:
        names += [*recording.channels, *recording.conditions, *recording.setpoints]
    assert not [name for name in names if "truth" in name or "starting" in name]


@pytest.mark.usefixtures("drawn_figures")
def test_report_is_reproducible_to_the_byte(finished, tmp_path):
    _, _, loaded = finished
    report = write_report(loaded.folder, load_registry(), out=tmp_path / "again.html")
    assert report.read_bytes() == loaded.report.read_bytes()


def test_disconnected_device_is_named_and_leaves_no_folder(tmp_path):
    station = station_file(tmp_path, ("{seed: 1}", "{seed: 1, simulate: unplugged}"))
    with pytest.raises(DeviceNotFoundError, match="tester"):
        run(
            quick_procedure(tmp_path, "no_load_inertia_sweep"),
            tmp_path / "runs",
            station=station,
        )
    assert not (tmp_path / "runs").exists()


def test_stopped_run_is_sealed_as_aborted_with_complete_recordings(tmp_path):
    stop = threading.Event()

    def stop_at_the_third_recording(event):
        if isinstance(event, StepStarted) and event.recording.startswith("003"):
            stop.set()

    finished = run(
        quick_procedure(tmp_path, "no_load_inertia_sweep"),
        tmp_path / "runs",
        listeners=[stop_at_the_third_recording],
        stop=stop,
    )
    assert finished.outcome is Outcome.ABORTED
    assert finished.exit_code is ExitCode.ABORTED
    stored = read(finished.folder)
    assert stored.info.sealed
    assert len(stored.recordings) == 2
    assert not (finished.folder / "result.json").exists()


def test_stopped_run_with_unsafe_rig_is_a_device_error(tmp_path, capsys):
    stop = threading.Event()
    lost = "{plugin: swing_tester_sim, settings: {seed: 1}, faults: [{kind: lost, on: make safe}]}"
    plain = "plugin: swing_tester_sim\n    settings: {seed: 1}"
    station = station_file(tmp_path, (plain, f"plugin: fault\n    settings: {lost}"))
    finished = run(
        quick_procedure(tmp_path, "no_load_inertia_sweep"),
        tmp_path / "runs",
        station=station,
        listeners=[lambda event: stop.set() if isinstance(event, StepStarted) else None],
        stop=stop,
    )
    assert isinstance(finished.error, AbortedError)
    assert finished.outcome is Outcome.ERROR
    assert finished.exit_code is ExitCode.DEVICE
    assert "; the rig is not safe: tester: make safe failed: " in read(finished.folder).info.reason
    show_finished(finished)
    assert "THE RIG IS NOT SAFE: tester: make safe failed: " in capsys.readouterr().err


def test_zero_out_of_limits_ends_run_before_any_motion(tmp_path):
    procedure = quick_procedure(
        tmp_path, "no_load_inertia_sweep", ("within: 0.05 N·m", "within: 0.00001 N·m")
    )
    finished = run(procedure, tmp_path / "runs")
    assert finished.outcome is Outcome.ERROR
    assert "zero" in finished.reason.lower()
    assert read(finished.folder).recordings == ()


def test_run_is_sealed_despite_failing_analysis(tmp_path):
    station = station_file(tmp_path, ("{seed: 1}", "{seed: 1, frequency_error: -80 %}"))
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep")
    finished = run(procedure, tmp_path / "runs", station=station)
    assert finished.outcome is Outcome.COMPLETED
    assert finished.exit_code is ExitCode.DATA
    assert "whole cycles" in str(finished.error)
    assert len(read(finished.folder).recordings) == 5


def test_device_that_cannot_be_closed_loses_no_result(tmp_path, monkeypatch):
    def jammed(_):
        raise DeviceLostError("the socket is gone")

    monkeypatch.setattr(Rig, "close", jammed)
    finished = run(quick_procedure(tmp_path, "no_load_inertia_sweep"), tmp_path / "runs")
    assert read(finished.folder).info.sealed
    assert finished.report.exists()
    assert finished.exit_code is ExitCode.DEVICE


@pytest.mark.parametrize("where", ["as it ends", "while the rig is closed", "in the analysis"])
def test_ctrl_c_after_the_end_of_a_run_leaves_it_sealed(tmp_path, monkeypatch, where):
    def press():
        signal.raise_signal(signal.SIGINT)

    def press_at_end(event):
        if isinstance(event, RunEnded) and where == "as it ends":
            press()

    def close_and_press(rig, close=Rig.close):
        if where == "while the rig is closed":
            press()
        close(rig)

    monkeypatch.setattr(Rig, "close", close_and_press)
    if where == "in the analysis":

        def analyse_and_press(*args, progress, **more):
            press()
            progress("recordings", 1, 5)
            return analyse_stored(*args, **more)

        monkeypatch.setattr("rigrunner.run.report.analyse_stored", analyse_and_press)
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep")
    with stop_on_signals() as stop:
        ended = run(procedure, tmp_path / "runs", stop=stop, listeners=[stop, press_at_end])
    assert ended.sealed
    assert ended.outcome is Outcome.COMPLETED
    assert read(ended.folder).info.outcome == Outcome.COMPLETED
    if where == "in the analysis":
        assert ended.exit_code is ExitCode.INTERRUPTED


def test_run_is_sealed_despite_interrupted_analysis(tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("rigrunner.run.report.analyse_stored", interrupted)
    finished = run(quick_procedure(tmp_path, "no_load_inertia_sweep"), tmp_path / "runs")
    assert read(finished.folder).info.sealed
    assert finished.exit_code is ExitCode.INTERRUPTED


def test_file_that_differs_from_its_manifest_after_sealing_is_reported(tmp_path, monkeypatch):
    def changed_meanwhile(folder, _):
        (folder / "run.h5").chmod(0o600)
        with h5py.File(folder / "run.h5", "r+") as file:
            samples = next(iter(file["entry/recordings"].values()))["tester_torque"]
            samples[7] += 1e-9

    monkeypatch.setattr(finish, "_write_result", changed_meanwhile)
    finished = run(quick_procedure(tmp_path, "no_load_inertia_sweep"), tmp_path / "runs")
    assert "tester_torque (recording): not what was sealed" in str(finished.error)
    assert finished.report is None
    assert finished.exit_code is ExitCode.DATA


def test_report_has_questions_and_answers(finished):
    _, _, loaded = finished
    analysed = AnalysedRun.of(*read_with_truth(loaded.folder), load_registry(), unseen)
    texts = [event["text"] for event in report_input(analysed, loaded.folder).events]
    assert any("guards closed. — yes (unattended answer" in text for text in texts)


@pytest.mark.thorough
def test_result_name_in_another_language_keeps_caveats_of_report(finished, tmp_path):
    folder, _, english = finished
    german = ("name: load-induced starting torque", "name: lastabhängiges Anlaufmoment")
    procedure = quick_procedure(tmp_path, "starting_torque_1000n", german)
    reports = [ended.report.read_text(encoding="utf-8") for ended in
               (english, run(procedure, folder / "runs"))]  # fmt: skip
    for words in ("not the breakaway torque from rest", "at zero load", "not growing with load",
                  "proportional to load", "limits of another quantity"):  # fmt: skip
        assert all(words in " ".join(report.split()) for report in reports), words


@pytest.mark.parametrize("method", ["document", "plot"])
def test_run_whose_details_fail_is_sealed_without_a_result(tmp_path, monkeypatch, method):
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep")
    (details,) = run(procedure, tmp_path / "runs").result.details

    def fail(_self):
        raise ZeroDivisionError("a bug of a plugin")

    monkeypatch.setattr(type(details), method, fail)
    finished = run(procedure, tmp_path / "runs")
    assert (finished.sealed, finished.result) == (True, None)
    assert isinstance(finished.error, ZeroDivisionError)
    assert read(finished.folder).info.outcome == "completed"
