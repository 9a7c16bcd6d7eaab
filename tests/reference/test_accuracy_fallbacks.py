"""Accuracy without an angle channel, on random rigs of both models.

The index is anywhere within the tolerance that the station states; sensors, noise and resonance
differ from rig to rig.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from helpers_rigs import true_starting_torque_nm
from reference.helpers_motion import BY_ENTRY, random_rig, run_by
from rigrunner.analysis.analyse import analyse
from rigrunner.analysis.document import document
from rigrunner.api.analysis import Consequence
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.study.tools import analysis_ref
from rigrunner_bearings.torque.settings import SwingTorque
from unit.analysis.helpers_analysis import MEASURAND, registry

pytestmark = pytest.mark.thorough

HERTZ = (3.0, 10.0, 20.0, 25.0, 35.0)
RIGS = [("closed", 1), ("closed", 2), ("ode", 3), ("ode", 4)]
PEAKS = {"paper_peak", "peak_same_frequency"}
SPEC = SwingTorque.model_validate(
    {
        "despike": {"hampel": {"window": 11}},
        "outliers": {"grubbs": {"alpha": 0.05}},
        "fits": [{"polynomial": {"degree": 2}}],
        "no_load": {"from": "latest", "procedure": "SSPB-NLI"},
        "compensations": ["paper_peak", "peak_same_frequency", "template_inverse", "energy"],
        "primary": "template_inverse",
    }
)


def rig_of(model, seed, **sensors):
    place = np.deg2rad(np.random.default_rng([seed, 7]).uniform(-1, 1))
    rig = random_rig(model, seed)
    return replace(rig, sensors=replace(rig.sensors, index_phase_rad=place, **sensors))


@lru_cache(maxsize=16)
def result(model, seed, motion):
    return analysed(rig_of(model, seed), seed, motion)


def analysed(rig, seed, motion):
    loaded, no_load = (
        run_by(motion, rig, load, HERTZ, seed=seed, cycles=15) for load in (1000.0, 0.0)
    )
    run = replace(loaded, partners={"no_load": no_load})
    refs = (analysis_ref(SPEC),)
    return analyse(run, refs, acceptance=None, measurand=MEASURAND, lookup=registry())


def errors_and_expanded(motion):
    """Return error and U of template_inverse over all rigs, each of shape (rigs, points)."""
    errors, expanded = [], []
    for model, seed in RIGS:
        rig = rig_of(model, seed)
        for point in (
            TorqueDetails.of(result(model, seed, motion)).compensations["template_inverse"].points
        ):
            truth = true_starting_torque_nm(rig, 1000.0, point.set_frequency_hz)
            errors.append(point.torque.value - truth)
            expanded.append(coverage_factor(point.torque.dof) * point.torque.u)
    return np.array(errors), np.array(expanded)


def test_waveform_methods_by_tacho_are_nearly_as_accurate():
    errors, expanded = errors_and_expanded("velocity")
    assert np.sqrt(np.mean(errors**2)) <= 0.008
    assert (np.abs(errors) <= expanded).mean() >= 0.95


def test_waveform_methods_by_index_state_larger_uncertainty():
    errors, expanded = errors_and_expanded("index")
    assert np.sqrt(np.mean(errors**2)) <= 0.02
    assert (np.abs(errors) <= expanded).mean() >= 0.95
    assert np.median(expanded) > 1.2 * np.median(errors_and_expanded("velocity")[1])


@pytest.mark.parametrize(("model", "seed"), RIGS)
def test_only_peak_methods_apply_by_entered_frequency(model, seed):
    entered = result(model, seed, BY_ENTRY)
    by_angle = result(model, seed, "velocity")
    for name, compensation in TorqueDetails.of(entered).compensations.items():
        assert bool(compensation.points) == (name in PEAKS)
    for name in PEAKS:
        torques, expected = (
            np.array(
                [point.torque.value for point in TorqueDetails.of(item).compensations[name].points]
            )
            for item in (entered, by_angle)
        )
        assert torques == pytest.approx(expected, abs=0.02)
    assert entered.headline is None
    assert "needs an angle channel" in entered.notes[0]


def test_missing_angle_is_in_checks_and_document():
    entered = result("closed", 1, BY_ENTRY)
    names = {check.name: check for check in entered.checks}
    assert names["angle channel"].consequence is Consequence.NOTE
    assert names["no-load run: angle channel"].consequence is Consequence.NOTE
    assert names["entered frequency"].consequence is Consequence.NOTHING
    content = document(entered)
    assert content["points"][0]["motion"] == "entered"
    assert "angle channel" in content["compensations"]["energy"]["not_applicable"]
    assert content["headline"]["compensated"] is None


def test_entry_wrong_by_5_percent_is_flagged_without_motion():
    wrong = analysed(rig_of("closed", 5, frequency_error=0.05), 5, BY_ENTRY)
    check = next(check for check in wrong.checks if check.name == "entered frequency")
    assert check.consequence is Consequence.NOTE
    assert "entered 10 Hz, torque repeats at 10.5 Hz" in check.text
