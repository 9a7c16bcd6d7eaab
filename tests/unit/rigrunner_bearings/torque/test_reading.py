"""Readings that are corrected by the points of a calibration certificate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner.api.data import Recording
from rigrunner.api.instruments import Instrument
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.torque.reading import torque_reading
from unit.analysis.helpers_analysis import analysed, no_load_spec, recording, run_of

CHANNEL = "tester.torque"
POINTS = [
    {"applied": "2 N·m", "indicated": "2.01 N·m", "U": "4 mN·m"},
    {"applied": "6 N·m", "indicated": "6.06 N·m", "U": "6 mN·m"},
    {"applied": "10 N·m", "indicated": "10.03 N·m", "U": "5 mN·m"},
]
ENTRY = {"channel": CHANNEL, "serial": "T-1", "full_scale": "10 N·m", "points": POINTS}


def instrument(**changes):
    return Instrument.model_validate(ENTRY | {"interpolation": "linear"} | changes)


def run(torque, zero=0.0, **changes):
    data = Recording(
        name="10Hz", rate_hz=1000.0, started_utc="2026-01-01T12:00:00+00:00", setpoints={},
        channels={CHANNEL: torque}, units={CHANNEL: "N·m"},
    )  # fmt: skip
    data_run = run_of(data, zeros={CHANNEL: zero}, instruments={CHANNEL: instrument(**changes)})
    return data, data_run


@pytest.mark.parametrize(
    ("indicated", "applied"),
    [
        (2.01, 2.0), (6.06, 6.0), (10.03, 10.0),
        (0.0, 0.0), (1.005, 1.0), (4.035, 4.0), (8.045, 8.0),  # half-way between two points
        (11.0, 10.97),  # beyond: the deviation of the last point
        (-6.06, -6.0), (-1.005, -1.0),  # points of one direction are used for both
    ],
)  # fmt: skip
def test_deviation_of_points_is_subtracted(indicated, applied):
    data, data_run = run(np.array([indicated, 0.0]))
    torque = torque_reading(data, CHANNEL, data_run)
    assert isinstance(torque, np.ndarray)
    assert torque == pytest.approx([applied, 0.0], abs=1e-12)


def test_zero_is_subtracted_before_correction():
    data, data_run = run(np.array([6.56]), zero=0.5)
    assert torque_reading(data, CHANNEL, data_run) == pytest.approx([6.0], abs=1e-12)


def test_each_direction_has_its_own_points():
    directions = [*POINTS, {"applied": "-6 N·m", "indicated": "-5.97 N·m", "U": "6 mN·m"}]
    data, data_run = run(np.array([-5.97, 6.06]), points=directions)
    assert torque_reading(data, CHANNEL, data_run) == pytest.approx([-6.0, 6.0], abs=1e-12)


def test_nothing_is_corrected_without_interpolation():
    data, data_run = run(np.array([6.06, 2.0]), interpolation=None)
    assert torque_reading(data, CHANNEL, data_run) == pytest.approx([6.06, 2.0], abs=0)


def test_stored_samples_are_corrected_as_they_are_read():
    class Stored:
        values = np.linspace(-9.0, 9.0, 101)

        def __len__(self):
            return len(self.values)

        def __getitem__(self, which):
            return self.values[which]

    data, data_run = run(Stored.values)
    expected = torque_reading(data, CHANNEL, data_run)
    stored = replace(data, channels={CHANNEL: Stored()})
    torque = torque_reading(stored, CHANNEL, data_run)
    assert not isinstance(torque, np.ndarray)
    assert len(torque) == 101
    assert torque[10:20] == pytest.approx(expected[10:20], abs=0)
    assert np.asarray(torque) == pytest.approx(expected, abs=0)
    assert torque.limits == pytest.approx((expected.min(), expected.max()), abs=0)


def test_result_is_of_corrected_peaks():
    """Peaks of 6.06 and 2.01 N·m are 6 and 2 N·m."""
    peaks = {5.0: 2.01, 10.0: 6.06}
    recordings = (recording(np.full(10, p), f, load_n=0.0) for f, p in peaks.items())
    low_pass = {"type": "butterworth", "order": 2, "corner": "1 kHz"}
    data_run = run_of(*recordings, instruments={CHANNEL: instrument(low_pass=low_pass)})
    points = TorqueDetails.of(analysed(data_run, None, no_load_spec())).loaded
    assert [p.peak_nm.mean() for p in points] == pytest.approx([2.0, 6.0], rel=1e-3)


def test_limit_of_error_is_that_after_correction():
    """The greatest U plus the distance of 6.06 from the line of 2.01 and 10.03: some 40 mN·m."""
    line = 0.01 + (0.03 - 0.01) * (6.06 - 2.01) / (10.03 - 2.01)
    assert instrument().half_width("overall") == pytest.approx(0.006 + 0.06 - line, rel=1e-9)
    uncorrected = instrument(interpolation=None)
    assert uncorrected.half_width("overall") == pytest.approx(0.066, rel=1e-9)


CUBIC = (4e-3, -2e-4, 3e-5)
"""A deviation of 4e-3 x - 2e-4 x² + 3e-5 x³ at the indicated x, in N·m."""


def on_the_cubic(*indicated, off=()):
    """Return the points of a certificate with the deviations of that curve plus `off`."""
    points = []
    for place, x in enumerate(indicated):
        deviation = np.sign(x) * sum(c * abs(x) ** k for k, c in enumerate(CUBIC, 1))
        deviation += off[place] if len(off) else 0.0
        points.append(
            {"applied": f"{x - deviation:.9f} N·m", "indicated": f"{x:.9f} N·m", "U": "4 mN·m"}
        )
    return points


def test_cubic_passes_through_the_points():
    """Between the points as well, where straight lines are off by 0.5 mN·m."""
    points = on_the_cubic(2.0, 4.0, 6.0, 8.0, 10.0)
    torque = np.array([-9.0, -1.0, 0.0, 1.0, 3.3, 9.0, 12.0])
    data, data_run = run(torque, points=points, interpolation="cubic")
    reach = np.clip(torque, -10, 10)  # beyond: the deviation of the last point
    deviation = np.sign(reach) * sum(c * abs(reach) ** k for k, c in enumerate(CUBIC, 1))
    assert torque_reading(data, CHANNEL, data_run) == pytest.approx(torque - deviation, abs=1e-6)


def test_each_direction_has_its_own_cubic():
    """The negative one is steeper by 0.1 N·m per 10 N·m; zero belongs to both."""
    points = on_the_cubic(2.0, 4.0, 6.0, 8.0, 10.0)
    points += on_the_cubic(-2.0, -5.0, -7.0, -10.0, off=(-0.02, -0.05, -0.07, -0.1))
    data, data_run = run(np.array([-6.0, 0.0, 6.0]), points=points, interpolation="cubic")
    curve = sum(c * 6.0**k for k, c in enumerate(CUBIC, 1))
    expected = [-6.0 + curve + 0.06, 0.0, 6.0 - curve]
    assert torque_reading(data, CHANNEL, data_run) == pytest.approx(expected, abs=1e-6)


def test_limit_of_error_of_cubic_is_its_residual():
    """The residuals are orthogonal to any cubic without constant over five equal steps from zero,
    so the fit leaves them as they are."""
    indicated = np.array([2.0, 4.0, 6.0, 8.0, 10.0])
    powers = np.stack([indicated**k for k in (1, 2, 3)], axis=1)
    residual = np.linalg.svd(powers)[0][:, 3] * 0.01  # at right angles to all three
    points = on_the_cubic(*indicated, off=residual)
    half_width = instrument(points=points, interpolation="cubic").half_width("overall")
    assert half_width == pytest.approx(0.004 + np.abs(residual).max(), rel=1e-4)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (POINTS, "a cubic needs 4 points in each direction that has any, got 3"),
        (
            [*on_the_cubic(2.0, 4.0, 6.0, 8.0), *on_the_cubic(-3.0)],
            "a cubic needs 4 points in each direction that has any, got 1",
        ),
    ],
)
def test_too_few_points_for_a_cubic_are_refused(points, message):
    with pytest.raises(ValidationError, match=message):
        instrument(points=points, interpolation="cubic")


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (POINTS[:1], "interpolation needs 2 points or more, got 1"),
        ([POINTS[0], {**POINTS[1], "indicated": "1.9 N·m"}], "must rise with applied"),
        ([POINTS[0], POINTS[0]], "must rise with applied, and does not at 2 N·m"),
    ],
)
def test_points_without_curve_are_refused(points, message):
    with pytest.raises(ValidationError, match=message):
        instrument(points=points)
