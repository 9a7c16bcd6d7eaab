"""A long recording is followed by its latest cycles, as the stored analysis would see them."""

from __future__ import annotations

import numpy as np
import pytest

from helpers_workflow import FEW_FREQUENCIES, quick_procedure, run
from rigrunner.api.events import Samples, StepEnded
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_station, run_names
from rigrunner.runfile import read
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_panel.live import analyst
from rigrunner_panel.live.latest import LatestCycles
from rigrunner_panel.process.messages import Analyse


class Follower:
    """Follows a run from inside it, as the analyst's process does beside it."""

    def __init__(self, runs, partners):
        self.runs, self.partners, self.unfinished = runs, partners, None
        self.found, self._blocks = {}, 0

    def __call__(self, event):
        if self.unfinished is None:
            folder = self.runs / run_names(self.runs)[-1]
            self.unfinished = LatestCycles(folder, load_registry(), self.partners)
        if isinstance(event, Samples):
            self._blocks += 1
            if self._blocks % 3 == 0:
                self.found[event.recording] = self.unfinished.latest()


class Asker:
    """Asks an analyst for the recording that goes on and for the finished ones."""

    def __init__(self, runs):
        self.runs, self.analyst, self.answers, self._blocks = runs, analyst._Analyst(), [], 0

    def __call__(self, event):
        self._blocks += isinstance(event, Samples)
        is_asked = isinstance(event, Samples) and self._blocks % 4 == 0
        if is_asked or (isinstance(event, StepEnded) and event.recording):
            folder = self.runs / run_names(self.runs)[-1]
            recording = event.recording if isinstance(event, Samples) else ""
            asked = Analyse(folder, find_station("simulated"), recording)
            self.answers.append((event, self.analyst.answer(asked)))


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """Return a folder, its runs, and a no-load run in it."""
    folder = tmp_path_factory.mktemp("unfinished")
    runs = folder / "runs"
    return folder, runs, run(quick_procedure(folder, "no_load_inertia_sweep"), runs).folder


def loaded(lab, listener):
    folder, runs, _ = lab
    changes = ("cycles: 12}", "cycles: 60}"), (FEW_FREQUENCIES, "[20 Hz, 35 Hz]")
    procedure = quick_procedure(folder, "starting_torque_1000n", *changes)
    finished = run(procedure, runs, listeners=[listener])
    assert finished.error is None
    return finished


def test_the_latest_cycles_give_the_value_of_the_recording_within_its_uncertainty(lab):
    follower = Follower(lab[1], {"no_load": read(lab[2])})
    finished = loaded(lab, follower)
    assert list(follower.found) == [
        point.recording for point in TorqueDetails.of(finished.result).loaded
    ]
    whole = (
        TorqueDetails.of(finished.result)
        .compensations[TorqueDetails.of(finished.result).primary]
        .points
    )
    for point, known, (result, cycles) in zip(
        TorqueDetails.of(finished.result).loaded, whole, follower.found.values(), strict=True
    ):
        (latest,) = TorqueDetails.of(result).compensations[TorqueDetails.of(result).primary].points
        assert TorqueDetails.of(result).loaded[-1].recording == point.recording
        assert 8 <= TorqueDetails.of(result).loaded[-1].cycles <= cycles <= point.cycles
        assert cycles > point.cycles / 2
        assert abs(latest.torque.value - known.torque.value) < 2 * latest.torque.u
        assert latest.raw_nm == pytest.approx(known.raw_nm, abs=0.05)


@pytest.mark.thorough
def test_a_long_recording_is_followed_and_a_finished_one_is_whole(lab, monkeypatch):
    monkeypatch.setattr(analyst, "MOST_AGAIN", 20_000)
    asker = Asker(lab[1])
    finished = loaded(lab, asker)
    views = [(event, answer.view) for event, answer in asker.answers if answer.view is not None]
    assert not [view.problem for _, view in views if view.problem]
    counts = [len(view.points) for _, view in views]
    assert counts == sorted(counts)
    assert counts[-1] == len(TorqueDetails.of(finished.result).loaded)
    last_of = {event.recording: view for event, view in views if isinstance(event, StepEnded)}
    final = TorqueDetails.of(finished.result).loaded
    last = last_of[final[-1].recording]
    assert [each.cycles for each in last.points] == [each.cycles for each in final]
    assert last.headline.value_nm == finished.result.headline.value
    going = [view for event, view in views if isinstance(event, Samples)]
    assert all(np.isfinite(view.points[-1].torque_nm) for view in going)


@pytest.mark.thorough
def test_when_too_much_is_recorded_each_recording_is_still_followed(lab, monkeypatch):
    monkeypatch.setattr(analyst, "MOST_BYTES", 1_000)
    asker = Asker(lab[1])
    finished = loaded(lab, asker)
    last = asker.answers[-1][1].view
    assert last.problem == analyst.TOO_MUCH
    assert last.headline is None  # the mean of whole recordings alone
    assert [each.recording for each in last.points] == [
        e.recording for e in TorqueDetails.of(finished.result).loaded
    ]
    whole = (
        TorqueDetails.of(finished.result)
        .compensations[TorqueDetails.of(finished.result).primary]
        .points
    )
    for shown, known in zip(last.points, whole, strict=True):
        assert shown.torque_nm == pytest.approx(known.torque.value, abs=0.03)
