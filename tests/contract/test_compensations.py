"""What every compensation of the registry keeps to with the analysis before it.

Where the channels have their zero is none of a method's business, nor what was entered where the
angle tells. What is a method's own doing is held by the conformance kit.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from helpers_thorough import first
from reference.helpers_motion import BY_ENTRY, run_by
from rigrunner.analysis.analyse import analyse
from rigrunner.api.data import Measurement
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from rigrunner_bearings.study.tools import analysis_ref
from rigrunner_bearings.torque.settings import SwingTorque
from unit.analysis.helpers_analysis import MEASURAND, registry

OF_STARTS = {"breakaway_peak"}
"""These take starts from rest, not swings."""
METHODS = sorted(set(registry().names("compensation")) - OF_STARTS)
PEAKS = {"paper_peak", "peak_same_frequency"}
"""These need the peaks only; all others compare whole swings."""
HERTZ = (5.0, 10.0, 20.0, 28.0, 35.0)
RIG = RigParameters()

pytestmark = pytest.mark.parametrize(
    "method",
    # template_inverse has all of model_inverse but how the bearing is found
    [
        pytest.param(each, marks=[pytest.mark.thorough] * (each == "model_inverse"))
        for each in METHODS
    ],
)


@lru_cache(maxsize=16)
def recorded(load_n, motion="angle", rate_hz=10e3):
    rig = replace(RIG, sensors=replace(RIG.sensors, sample_rate_hz=rate_hz))
    return run_by(motion, rig, load_n, HERTZ, seed=3, cycles=12)


@lru_cache(maxsize=16)
def plain(method):
    return compensated(method, recorded(1000.0), recorded(0.0))


def compensated(method, loaded, no_load):
    spec = SwingTorque.model_validate(
        {
            "despike": {"hampel": {"window": 11}},
            "outliers": {"grubbs": {"alpha": 0.05}},
            "fits": [{"polynomial": {"degree": 2}}],
            "no_load": {"from": "latest", "procedure": "SSPB-NLI"},
            "compensations": [method],
        }
    )
    run = replace(loaded, partners={"no_load": no_load} if no_load else {})
    refs = (analysis_ref(spec),)
    result = analyse(run, refs, acceptance=None, measurand=MEASURAND, lookup=registry())
    return TorqueDetails.of(result).compensations[method]


def changed(run, change, **fields):
    """Return the run with every recording changed."""
    return replace(run, recordings=tuple(change(each) for each in run.recordings), **fields)


def with_offset(run, channel, offset):
    return changed(
        run,
        lambda rec: replace(
            rec, channels=dict(rec.channels) | {channel: rec.channels[channel] + offset}
        ),
    )


def torques(found):
    assert not found.not_applicable
    return np.array([point.torque.value for point in found.points])


def expanded(found):
    return np.array([coverage_factor(p.torque.dof) * p.torque.u for p in found.points])


def frequency_parts(found):
    """Return what not knowing the frequency adds, in N·m."""
    return np.array([p.u for c in found.points for p in c.components if p.name == "frequency"])


def test_a_zero_reading_is_taken_off(method):
    """A torque channel that is off by the same in the zero reading and the recordings."""
    loaded, no_load = (
        replace(
            with_offset(run, "tester.torque", 0.5),
            zeros={"tester.torque": run.zeros["tester.torque"] + 0.5},
        )
        for run in (recorded(1000.0), recorded(0.0))
    )
    found = compensated(method, loaded, no_load)
    assert torques(found) == pytest.approx(torques(plain(method)), abs=1e-7)  # searches end there


def test_the_zero_of_the_angle_does_not_matter(method):
    loaded, no_load = (
        with_offset(run, "tester.angle", 0.02) for run in (recorded(1000.0), recorded(0.0))
    )
    found = compensated(method, loaded, no_load)
    assert torques(found) == pytest.approx(torques(plain(method)), abs=1e-6)


def test_what_was_entered_does_not_matter_where_the_angle_tells(method):
    def mistyped(rec):
        return replace(rec, setpoints=dict(rec.setpoints) | {"tester.frequency": 99.0})

    found = compensated(method, changed(recorded(1000.0), mistyped), recorded(0.0))
    assert torques(found) == pytest.approx(torques(plain(method)), abs=1e-12)


def test_without_sign_of_motion_only_peak_methods_apply(method):
    found = compensated(method, recorded(1000.0, BY_ENTRY), recorded(0.0, BY_ENTRY))
    if method in PEAKS:
        assert (frequency_parts(found) > 10 * frequency_parts(plain(method))).all()
        assert any("entered" in note for note in found.notes)
    else:
        assert found.points == ()
        assert "needs an angle channel" in found.not_applicable


def test_single_values_serve_peak_methods_only(method):
    loaded, no_load = (_single_values(run) for run in (recorded(1000.0), recorded(0.0)))
    found = compensated(method, loaded, no_load)
    if method in PEAKS:
        assert len(found.points) == len(HERTZ)
        assert any("scatter is not known" in note for note in found.notes)
    else:
        assert "needs an angle channel" in found.not_applicable


@pytest.mark.parametrize("motion", first(1, ["velocity", "index"]))
def test_index_and_tacho_serve_every_method(method, motion):
    found = compensated(method, recorded(1000.0, motion), recorded(0.0, motion))
    off = np.abs(torques(found) - torques(plain(method)))
    assert (off <= expanded(found)).all()
    if method not in PEAKS:
        parts = {part.name for point in found.points for part in point.components}
        assert "place of the index or tacho" in parts
        assert ("time of the index pulse" in parts) == (motion == "index")


def _single_values(run):
    rows = tuple(
        Measurement(
            "peaks",
            rec.started_utc,
            rec.setpoints,
            {"tester.torque": float(np.sort(rec.channels["tester.torque"])[-20])},
            rec.units,
        )
        for rec in run.recordings
    )
    return replace(run, recordings=(), measurements=rows)
