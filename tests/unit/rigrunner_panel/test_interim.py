"""The interim analysis of a run in progress: its last value is the final one."""

from __future__ import annotations

import pickle
import queue
import subprocess
import sys
import threading
import time
from dataclasses import replace

import pytest

from helpers_any_quantity import written
from helpers_cli import call
from helpers_workflow import quick_procedure, run
from rigrunner.api.events import RunStarted, StepEnded
from rigrunner.api.figures import Axis, Figure, Series
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure, find_station, run_names
from rigrunner.runfile import read
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_panel.history import History
from rigrunner_panel.live import analyst
from rigrunner_panel.live.interim import interim_result
from rigrunner_panel.process.messages import Analyse, Analysed, Drawn, Follow
from rigrunner_panel.view.result import live_view
from rigrunner_panel.view.sections import LiveView


class Onlooker:
    """Analyses the run so far, after each recording."""

    def __init__(self, runs, partners):
        self.runs, self.partners = runs, partners
        self.registry = load_registry()
        self.after = []

    def __call__(self, event):
        if isinstance(event, StepEnded) and event.recording:
            folder = self.runs / run_names(self.runs)[-1]
            interim = interim_result(folder, self.registry, self.partners)
            self.after.append(None if interim is None else interim[0])


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """Run both procedures, the second with an onlooker; return it and the finished run."""
    folder = tmp_path_factory.mktemp("so_far")
    runs = folder / "runs"
    no_load = run(quick_procedure(folder, "no_load_inertia_sweep"), runs)
    onlooker = Onlooker(runs, {"no_load": read(no_load.folder)})
    finished = run(quick_procedure(folder, "starting_torque_1000n"), runs, listeners=[onlooker])
    assert finished.error is None
    return onlooker, finished


@pytest.mark.thorough
def test_last_live_value_equals_the_final_one(watched):
    onlooker, finished = watched
    last = live_view(onlooker.after[-1], final=True)
    final = live_view(finished.result, final=True)
    assert [result.value for result in last.results] == [result.value for result in final.results]
    assert last.headline == final.headline
    assert last.checks == final.checks
    assert len(final.results) == 5
    assert (last.verdict, final.verdict) == ("", "pass")  # nothing is decided before the end


@pytest.mark.thorough
def test_each_recording_adds_a_result(watched):
    onlooker, _ = watched
    views = [live_view(result, final=False) for result in onlooker.after]
    assert [len(view.results) for view in views] == [1, 2, 3, 4, 5]
    assert [view.recordings for view in views] == [1, 2, 3, 4, 5]
    assert len({view.results[0].uncorrected for view in views}) == 1


@pytest.mark.thorough
def test_watched_channels_are_analysed_in_place_of_the_recordings(watched):
    onlooker, finished = watched
    folder = finished.folder
    stretch = read(folder).recordings[2]
    result, _ = interim_result(folder, onlooker.registry, onlooker.partners, watched=stretch)
    expected = TorqueDetails.of(finished.result).compensations["template_inverse"].points[2]
    (row,) = live_view(result, final=False).results
    assert row.place == f"{stretch.setpoints['tester.frequency']:g} Hz"
    assert row.value == pytest.approx(expected.torque.value, abs=1e-3)


def test_unknown_uncertainty_is_none_in_result_and_history(
    tmp_path,
):
    """The tables of the paper have one value for each set-point, and no scatter."""
    finished = run(
        find_procedure("paper_reproduction"), tmp_path / "runs", station=find_station("paper")
    )
    view = live_view(finished.result, final=True)
    assert view.headline.U is None
    assert {row.U for row in view.results} == {None}
    assert LiveView.model_validate_json(view.model_dump_json()) == view
    (item,) = History(tmp_path / "runs").items()
    assert item.headline == view.headline


def test_named_results_are_shown_with_limits_during_the_run(tmp_path):
    """The run has manual readings of a power supply: no torque and no recordings."""
    procedure, station = written(tmp_path)
    runs = tmp_path / "runs"
    outcome = call("run", procedure, "--station", station, "--unattended", "--runs", runs)
    assert outcome.code == 0, outcome.err
    result, acceptance = interim_result(runs / run_names(runs)[0], load_registry(), {})
    view = live_view(result, final=False, acceptance=acceptance)
    assert view.verdict == ""
    voltages = [row for row in view.results if row.name == "voltage"]
    assert [(row.place, row.value) for row in voltages] == [
        ("0 A", 12.031), ("1 A", 12.022), ("2 A", 12.014), ("5 A", 11.987),
    ]  # fmt: skip
    assert {(row.lower, row.upper, row.unit) for row in voltages} == {(11.98, 12.1, "V")}
    (regulation,) = (row for row in view.results if row.name == "regulation")
    assert (regulation.place, regulation.lower, regulation.upper) == ("", None, 50.0)
    (figure,) = view.figures
    assert [point.x for point in figure.series[0].points] == [0, 1, 2, 5]
    drawn = Figure("given", Axis("x"), Axis("y"), (Series.over([1, 2], [2, 3], kind="line"),))
    view = live_view(replace(result, figures=(drawn,)), final=True, acceptance=acceptance)
    assert view.figures == (figure, drawn)
    assert LiveView.model_validate_json(view.model_dump_json()) == view
    (item,) = History(runs).items()
    assert (item.headline, item.result) == (None, "regulation: 44.0 ± 3.1 mV")


def test_live_curves_do_not_wait_for_analysis_of_recordings(monkeypatch, tmp_path):
    proceed, messages, runs = threading.Event(), queue.Queue(), tmp_path / "runs"
    live_analyst = analyst.Analyst(messages.put)

    def slow(*_):
        if threading.current_thread() is not threading.main_thread():
            proceed.wait()

    def listen(event):
        if isinstance(event, RunStarted):
            live_analyst.take(Follow(runs / event.run_id, find_station("simulated")))
        live_analyst.take(event)
        if isinstance(event, StepEnded) and event.recording.startswith("001"):
            live_analyst.take(Analyse(None))

    monkeypatch.setattr(analyst, "interim_result", slow)
    run(quick_procedure(tmp_path, "no_load_inertia_sweep"), runs, listeners=[listen])
    curves = {message.recording for message in messages.queue if isinstance(message, Drawn)}
    assert len(curves) == 5
    assert not [message for message in messages.queue if isinstance(message, Analysed)]
    proceed.set()
    answers = iter(lambda: messages.get(timeout=60), None)
    assert next(message for message in answers if isinstance(message, Analysed))


IN_HDF5 = """
import sys, time
from pathlib import Path
import h5py._objects
from rigrunner_panel.live import analyst

def busy(*_):
    with h5py._objects.phil:
        Path(sys.argv[1]).touch()
        time.sleep(600)

analyst.interim_result = busy
analyst.main()
"""


def test_process_exits_while_a_thread_holds_the_hdf5_lock(quick, tmp_path):
    """At exit the interpreter waits for the lock of HDF5, which this thread never releases."""
    begun = tmp_path / "begun"
    command = [sys.executable, "-c", IN_HDF5, str(begun)]
    messages = (Follow(quick.loaded, find_station("simulated")), Analyse())
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        for message in messages:
            process.stdin.write(pickle.dumps(message))
        process.stdin.flush()
        while not begun.exists():
            time.sleep(0.05)
        process.stdin.close()
        try:
            assert process.wait(timeout=60) == 0
        finally:
            process.kill()
