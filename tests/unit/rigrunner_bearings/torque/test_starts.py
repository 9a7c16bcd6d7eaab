from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

from rigrunner.api.data import Recording
from rigrunner.api.errors import DataError
from rigrunner.api.verdict import Verdict
from rigrunner.procedure import Acceptance
from rigrunner_bearings.api.points import StartPoint
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.torque.settings import Breakaway, SwingTorque
from unit.analysis.helpers_analysis import (
    MEASURAND,
    RATE_HZ,
    analysed,
    instrument,
    recording,
    run_of,
)

SPEC = {"compensations": ["breakaway_peak"]}
PEAKS = [0.30, 0.31, 0.29, 0.305, 0.295, 0.30]
SPEED_HZ = 2 / 60


def start(peak_nm, number=1, *, speed_hz=SPEED_HZ, zero_nm=0.0, spike_nm=0.0) -> Recording:
    """Return half a second of rest, then even rotation under a torque that stays at the peak."""
    travel = np.concatenate([np.zeros(1000), np.arange(1, 3001) * 2 * np.pi * speed_hz / RATE_HZ])
    torque = np.where(travel > 0, peak_nm, 0.0) + zero_nm
    torque[1200] += spike_nm
    return Recording(
        name=f"{number:03d}",
        rate_hz=RATE_HZ,
        started_utc="2026-01-01T12:00:00+00:00",
        setpoints={"tester.frequency": 0.0, "tester.start_frequency": speed_hz},
        channels={"tester.angle": travel, "tester.torque": torque},
        units={"tester.angle": "rad", "tester.torque": "N·m"},
    )


def starts(peaks=PEAKS, **options):
    return [start(peak, number, **options) for number, peak in enumerate(peaks, 1)]


NO_LOAD = {"nature": "no_load", "condition": "from_rest"}


def result_of(recordings, limit=None, zeros=0.0, sensor=None, **changes):
    run = run_of(*recordings, zeros={"tester.torque": zeros})
    if sensor is not None:
        run = replace(run, instruments={"tester.torque": sensor})
    accept = None
    if limit is not None:
        mean = {"of": "torque", "mean": True, "source": "a test", "measurand": NO_LOAD}
        accept = Acceptance.model_validate({"limits": [mean | limit]})
    return analysed(run, None, Breakaway.model_validate(SPEC | changes), accept)


def test_each_recording_gives_one_torque():
    result = result_of(starts(zero_nm=0.02), zeros=0.02)
    (point,) = TorqueDetails.of(result).loaded
    assert isinstance(point, StartPoint)
    assert point.peak_nm == pytest.approx(PEAKS)
    assert point.frequency_hz.value == pytest.approx(SPEED_HZ, rel=1e-9)
    assert (point.set_frequency_hz, point.load_n) == (SPEED_HZ, 0.0)
    assert point.recording == "001 to 006"


def test_mean_minus_half_fixture_friction_has_full_budget():
    sensor = instrument(full_scale="2 N·m", gain="1 %", drift="2 mN·m", nonlinearity="0.1 %")
    method = {"breakaway_peak": {"fixture_friction": "0.012 N·m"}}
    result = result_of(starts(), sensor=sensor, compensations=[method])
    scatter = np.std(PEAKS, ddof=1) / sqrt(6)
    widths = [0.01 * 0.294, 0.001 * 2, 0.002, 0.006]
    assert result.headline.value == pytest.approx(0.3 - 0.006)
    assert result.headline.u == pytest.approx(
        sqrt(scatter**2 + sum(width**2 / 3 for width in widths)), rel=1e-5
    )
    assert result.headline.dof == pytest.approx(5 * (result.headline.u / scatter) ** 4)
    assert (
        TorqueDetails.of(result).compensations["breakaway_peak"].measurand
        == "breakaway torque from rest"
    )
    assert result.settings["starts"] == {"window": pytest.approx(np.pi / 36), "smoothing": 0.005}


@pytest.mark.parametrize(
    ("limit", "verdict"),
    [
        ({"min": "0.25 in·lbf", "max": "8.0 in·lbf"}, Verdict.PASS),
        ({"max": "0.25 N·m"}, Verdict.FAIL),
        ({"min": "0.35 N·m"}, Verdict.FAIL),
    ],
)
def test_result_is_decided_against_limits(limit, verdict):
    assert result_of(starts(), limit).decision.verdict is verdict


def test_outlying_start_is_rejected_and_listed():
    peaks = [*PEAKS, 0.301, 0.299, 0.45]
    (point,) = TorqueDetails.of(
        result_of(starts(peaks), outliers={"grubbs": {"alpha": 0.05}})
    ).loaded
    assert [rejection.index for rejection in point.peak_rejections] == [8]
    assert point.peak_kept.tolist() == [True] * 8 + [False]


def test_spikes_are_removed_first():
    spiky = starts(spike_nm=5.0)
    (spiked,), (clean,) = (
        TorqueDetails.of(result_of(spiky, **options)).loaded
        for options in ({}, {"despike": {"hampel": {"window": 11}}})
    )
    assert clean.peak_nm == pytest.approx(PEAKS)
    assert clean.spikes == len(PEAKS)
    assert (spiked.peak_nm > 0.5).all()


def test_starts_at_two_speeds_are_two_points():
    fast = starts([0.4, 0.41, 0.42], speed_hz=2 * SPEED_HZ)
    points = TorqueDetails.of(result_of(starts() + fast)).loaded
    assert [point.set_frequency_hz for point in points] == [SPEED_HZ, 2 * SPEED_HZ]
    assert [len(point.peak_nm) for point in points] == [6, 3]


def test_two_starts_are_too_few():
    with pytest.raises(DataError, match="001 to 002: 2 starts, but 3 are needed"):
        result_of(starts(PEAKS[:2]))


def test_recording_without_start_is_refused_by_name():
    moving = starts()
    angle = moving[3].channels["tester.angle"] + np.arange(4000) * 1e-3
    moving[3] = replace(moving[3], channels=moving[3].channels | {"tester.angle": angle})
    with pytest.raises(DataError, match=r"recording 004, tester.angle: it does not begin"):
        result_of(moving)
    bare = [replace(start, channels={"tester.torque": np.ones(9)}) for start in starts()]
    with pytest.raises(DataError, match="recording 001 has no angle channel, and a start"):
        result_of(bare)


def test_swings_are_not_starts():
    result = analysed(
        run_of(recording([1.0] * 12)),
        None,
        SwingTorque.model_validate({"compensations": ["breakaway_peak"]}),
    )
    assert (
        "reversals is another torque"
        in TorqueDetails.of(result).compensations["breakaway_peak"].not_applicable
    )
    assert result.measurand == MEASURAND.name
