"""No-load points before and after the loaded ones: drift in between is removed."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from helpers_rigs import run_data, true_starting_torque_nm
from rigrunner.analysis.analyse import analyse
from rigrunner.api.errors import DataError
from rigrunner.registry import load_registry
from rigrunner.signal.coverage import expanded
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from rigrunner_bearings.study.tools import analysis_ref
from rigrunner_bearings.torque.settings import SwingTorque
from unit.analysis.helpers_analysis import MEASURAND

FREQUENCIES = (5.0, 10.0, 20.0, 30.0, 35.0)
START = datetime(2026, 1, 1, 12, tzinfo=UTC)
RIG = RigParameters()
WARMING = 0.06
"""The part by which the support's friction falls over the run."""
PLACES = {"before": 0.0, "loaded": 0.5, "after": 1.0}
DRIFT_NAME = "drift between the no-load points"


def support(place):
    return replace(RIG, support_friction_nm=RIG.support_friction_nm * (1 - WARMING * place))


def part(name, place, celsius):
    """Return the recordings of one part of the run, which takes an hour."""
    load_n = 1000.0 if name == "loaded" else 0.0
    run = run_data(support(place), load_n, FREQUENCIES, seed=3)
    started = START + timedelta(hours=PLACES[name])
    return tuple(
        replace(
            recording,
            name=f"{name} {recording.name}",
            started_utc=started.isoformat(),
            conditions={**recording.conditions, "tester.temperature": 273.15 + celsius},
        )
        for recording in run.recordings
    )


def run_of(friction, celsius=(20.0, 20.0, 20.0), parts=tuple(PLACES)):
    """Return a run whose support friction is at these places between its start and end values."""
    arguments = zip(PLACES, friction, celsius, strict=True)
    recordings = sum((part(*place) for place in arguments if place[0] in parts), ())
    return replace(run_data(RIG, 1000.0, FREQUENCIES[:1], seed=3), recordings=recordings)


def compensate(run, **no_load):
    spec = SwingTorque.model_validate(
        {
            "no_load": {"from": "this run", **no_load},
            "despike": {"hampel": {"window": 11}},
            "outliers": {"grubbs": {"alpha": 0.05}},
            "compensations": ["template_inverse"],
        }
    )
    result = analyse(
        run, (analysis_ref(spec),), acceptance=None, measurand=MEASURAND, lookup=load_registry()
    )
    return TorqueDetails.of(result).compensations["template_inverse"]


def between(before, loaded, after):
    return replace(loaded, partners={"no_load": before, "no_load_after": after})


def result_of_three(friction, **no_load):
    """Return the result of three separate runs, with the friction at these places."""
    before, loaded, after = (
        replace(run_of(friction, parts=(name,)), run_id=name, zeros={}) for name in PLACES
    )
    spec = SwingTorque.model_validate(
        {
            "no_load": {"procedure": "N", "after": True, **no_load},
            "despike": {"hampel": {"window": 11}},
            "outliers": {"grubbs": {"alpha": 0.05}},
            "compensations": ["template_inverse"],
        }
    )
    settings = {"acceptance": None, "measurand": MEASURAND, "lookup": load_registry()}
    return analyse(between(before, loaded, after), (analysis_ref(spec),), **settings)


def errors_nm(compensation):
    return np.array(
        [
            point.torque.value - true_starting_torque_nm(RIG, 1000.0, point.set_frequency_hz)
            for point in compensation.points
        ]
    )


def line(point):
    return next((part for part in point.components if part.name.startswith(DRIFT_NAME)), None)


STEADY = (0.0, 0.5, 1.0)


@pytest.fixture(scope="module")
def drifting():
    return compensate(run_of(STEADY))


def test_drift_over_time_is_removed(drifting):
    """3 % of 0.76 N·m, some 0.8 of it in the torque, against the points before alone."""
    uncorrected = compensate(run_of(STEADY, parts=("before", "loaded")))
    assert errors_nm(uncorrected).mean() < -0.014
    assert abs(errors_nm(drifting).mean()) < 0.003


def test_half_the_drift_is_a_budget_line(drifting):
    for error, point in zip(errors_nm(drifting), drifting.points, strict=True):
        drift = line(point)
        assert drift.name == f"{DRIFT_NAME} (time)"
        assert drift.common
        # 6 % of 0.76 N·m and 0.8 of it in the torque, half of that, rectangular
        assert drift.u == pytest.approx(0.5 * 0.06 * 0.76 * 0.82 / np.sqrt(3), rel=0.25)
        assert abs(error) < expanded(point.torque)


@pytest.mark.thorough
def test_interval_covers_nonlinear_drift():
    """Nearly all of the drift is before the loaded points."""
    sudden = compensate(run_of((0.0, 0.9, 1.0)))
    error = errors_nm(sudden)
    assert error.mean() < -0.010
    assert all(abs(e) < expanded(p.torque) for e, p in zip(error, sudden.points, strict=True))


@pytest.mark.thorough
def test_temperature_corrects_nonlinear_drift():
    warm = compensate(
        run_of((0.0, 0.9, 1.0), celsius=(20.0, 29.0, 30.0)), drift="tester.temperature"
    )
    assert line(warm.points[0]).name == f"{DRIFT_NAME} (tester.temperature)"
    assert abs(errors_nm(warm).mean()) < 0.003


@pytest.mark.thorough
def test_constant_temperature_falls_back_to_time():
    steady = compensate(run_of(STEADY), drift="tester.temperature")
    assert "by time, as tester.temperature does not tell" in line(steady.points[0]).name
    assert abs(errors_nm(steady).mean()) < 0.003


def test_points_on_one_side_only_have_no_drift_line():
    alone = compensate(run_of(STEADY, parts=("before", "loaded")))
    assert all(line(point) is None for point in alone.points)


def test_drift_over_channel_needs_points_before_and_after():
    with pytest.raises(ValueError, match="'drift' needs 'after: true' or 'from: this run'"):
        SwingTorque.model_validate(
            {"no_load": {"procedure": "SSPB-NLI", "drift": "tester.temperature"}}
        )


@pytest.mark.thorough
def test_separate_runs_equal_points_of_the_same_run(drifting):
    result = result_of_three(STEADY)
    apart = TorqueDetails.of(result).compensations["template_inverse"]
    np.testing.assert_allclose(errors_nm(apart), errors_nm(drifting), atol=1e-6)
    drift_u = ([line(p).u for p in outcome.points] for outcome in (apart, drifting))
    np.testing.assert_allclose(*drift_u, rtol=1e-3)
    assert result.run.partners["no_load_after"].run_id == "after"


def test_runs_that_do_not_bracket_loaded_run_are_refused():
    runs = [replace(run_of(STEADY, parts=(name,)), run_id=name) for name in PLACES]
    before, loaded, after = runs
    spec = SwingTorque.model_validate(
        {"no_load": {"procedure": "N", "after": True}, "compensations": ["template_inverse"]}
    )
    settings = {"acceptance": None, "measurand": MEASURAND, "lookup": load_registry()}
    with pytest.raises(DataError, match="before and loaded are not before and after after"):
        analyse(between(before, after, loaded), (analysis_ref(spec),), **settings)


def test_after_needs_separate_no_load_runs():
    with pytest.raises(ValueError, match="'after' is for a run of its own"):
        SwingTorque.model_validate({"no_load": {"from": "this run", "after": True}})
