"""Effects of problems in the recordings on a result, by the inputs of the budget."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import pytest

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation
from rigrunner_bearings.signal.kinematics import swing_angle
from rigrunner_bearings.torque.diagnosis import PreparedRuns, diagnose
from unit.analysis.helpers_analysis import RATIO, recording, run_of, swing_point

PEAKS = np.linspace(0.9, 1.1, 12)


def compensation(name, input_u, sensitivity):
    part = Component(
        name,
        abs(sensitivity) * input_u,
        inf,
        "rectangular",
        common=True,
        value=0.0,
        unit="1",
        input_u=input_u,
        sensitivity=sensitivity,
    )
    point = CompensatedPoint(10.0, 10.0, 2.0, 0.2, Estimate(0.8, 0.01), (part,))
    return Compensation("torque", (point,))


def biases_of(name, point, primary, *runs, moved_nm=()):
    """Return the biases of a check that must have failed."""
    run, no_load_run = (*runs, None, None)[:2]
    prepared_runs = PreparedRuns(
        run or run_of(recording(PEAKS)), no_load_run, (point,), (), moved_nm
    )
    (check,) = (c for c in diagnose(prepared_runs, primary, own_no_load=False) if c.name == name)
    assert not check.ok
    return [bias.value for bias in check.biases]


def point_with(scale=1.0):
    point = swing_point(PEAKS, 10.0)
    angle = swing_angle(np.arange(8) * np.pi / 4, RATIO * scale)
    return type(point)(**vars(point) | {"angle_rad": angle})


def test_stroke_error_acts_as_angle_scale_error():
    """0.3 N·m for 100 % of scale; the swing is 5 % too large, seen at 8 phases."""
    primary = compensation("angle scale", 0.005 / sqrt(3), 0.3)
    assert biases_of("stroke", point_with(1.05), primary) == [pytest.approx(0.015, rel=0.03)]


@pytest.mark.parametrize("line", ["sensor drift", "zero drift"])
def test_different_zeros_are_a_drift(line):
    """0.05 N·m between the zeros, a fortieth of which reaches the result."""
    run = run_of(recording(PEAKS), zeros={"tester.torque": 0.05})
    no_load = run_of(recording(PEAKS), zeros={"tester.torque": 0.0})
    primary = compensation(line, 0.02 / sqrt(3), 1 / 40)
    biases = biases_of("zero drift", point_with(), primary, run, no_load)
    assert biases == [pytest.approx(0.05 / 40)]


@pytest.mark.parametrize(("peak_nm", "moved_nm"), [(9.8, 0.0), (12.0, 0.0016)])
def test_error_curve_is_steeper_beyond_full_scale(peak_nm, moved_nm):
    """4 a x (1 - x) has the slope 4 a (1 - 2 x): by 0.4 of that at 1 more where x = 1.2.

    The limit is 0.1 %, and the result 4 N·m times the slope's share.
    """
    run = run_of(recording(np.full(12, peak_nm)))
    primary = compensation("sensor non-linearity", 0.001 / sqrt(3), 4.0)
    assert biases_of("range", point_with(), primary, run) == [pytest.approx(moved_nm, rel=0.01)]


def test_too_few_samples_act_as_half_of_them():
    primary = compensation("finite band", 0.001, 1.0)
    biases = biases_of("samples per cycle", point_with(), primary, moved_nm=(0.004,))
    assert biases == [0.004]


def test_problem_without_matching_input_is_a_note():
    primary = compensation("scatter between cycles", 0.001, 1.0)
    assert biases_of("stroke", point_with(1.05), primary) == [0.0]
