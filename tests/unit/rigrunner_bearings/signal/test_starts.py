from __future__ import annotations

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner_bearings.signal.starts import find_start

RATE_HZ = 2000.0
WINDOW, DEGREE = np.deg2rad(5), np.deg2rad(1)
REST = 1000


def motion(sense=1.0, offset_rad=0.0, moving=3000):
    """Return an angle that rests for 0.5 s and then turns at 12 deg/s, that is 2 rpm."""
    travel = np.concatenate([np.zeros(REST), np.arange(1, moving + 1) * np.deg2rad(12) / RATE_HZ])
    return offset_rad + sense * travel


def torque_over(angle_rad, peak_nm=0.3, at_rad=DEGREE, late_nm=0.1):
    """Return a torque with a parabolic peak at a travel, and a larger value after the window."""
    travel = np.abs(angle_rad - angle_rad[0])
    torque = peak_nm - 50 * (travel - at_rad) ** 2
    torque[travel > 2 * at_rad] = late_nm
    torque[travel == 0] = 0
    torque[travel > np.deg2rad(10)] = 2.0
    return torque


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("offset_rad", [0.0, -40.0])
def test_breakaway_is_first_peak_in_either_sense(sense, offset_rad):
    angle = motion(sense, offset_rad)
    start = find_start(angle, sense * torque_over(angle), RATE_HZ, WINDOW, 0.005)
    assert start.breakaway_nm == pytest.approx(0.3, abs=1e-4)
    assert np.degrees(start.travel_rad) == pytest.approx(1.0, abs=0.02)
    assert start.frequency_hz == pytest.approx(2 / 60, rel=1e-9)


def test_noise_does_not_bias_breakaway():
    """The greatest of 1500 noisy samples would be some 3 sigma high (Gumbel)."""
    angle, rng = motion(), np.random.default_rng(1)
    clean = torque_over(angle)
    starts = [
        find_start(angle, clean + 0.01 * rng.standard_normal(len(clean)), RATE_HZ, WINDOW, 0.01)
        for _ in range(50)
    ]
    assert np.mean([start.breakaway_nm for start in starts]) == pytest.approx(0.3, abs=0.01)
    sharp = find_start(angle, clean + 0.01 * rng.standard_normal(len(clean)), RATE_HZ, WINDOW, 0)
    assert sharp.breakaway_nm > 0.315


def test_recording_that_begins_in_motion_is_refused():
    angle = motion()[REST:]
    with pytest.raises(DataError, match="does not begin with rest"):
        find_start(angle, np.ones(len(angle)), RATE_HZ, WINDOW, 0.005)


@pytest.mark.parametrize("moving", [0, 500, 833])
def test_too_little_travel_is_refused_with_its_value(moving):
    angle = motion(moving=moving)
    turned = np.degrees(angle[-1])
    with pytest.raises(DataError, match=f"turns by {turned:.3g} deg, but more than 5 deg"):
        find_start(angle, np.ones(len(angle)), RATE_HZ, WINDOW, 0.005)
