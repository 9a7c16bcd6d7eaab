"""The effect of a low sample rate on a torque."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation, Sweep
from rigrunner_bearings.torque.sampling import with_half_the_samples
from unit.analysis.helpers_analysis import RIG, instrument, swing_point

SIZE = 1024
PHASE = 2 * np.pi * np.arange(SIZE) / SIZE


def point_of(wave, samples_per_cycle):
    return replace(
        swing_point([1.0, 1.0], 10.0),
        torque_nm=np.tile(wave, (2, 1)),
        sample_rate_hz=10.0 * samples_per_cycle,
    )


def greatest(sweep):
    """Return the greatest torque as a compensation."""
    value = float(sweep.loaded[0].torque_nm.max())
    return Compensation("torque", (CompensatedPoint(10, 10, 1, 0, Estimate(value, 0.1), ()),))


def effects_of(wave, samples_per_cycle, method=greatest):
    sweep = Sweep((point_of(wave, samples_per_cycle),), (), RIG, instrument(), None)
    return with_half_the_samples(method, sweep, greatest(sweep))


def test_enough_samples_are_not_checked():
    assert effects_of(np.sin(PHASE), 280.0) == ()


def test_smooth_torque_is_unaffected():
    assert effects_of(np.cos(PHASE), 100.0) == (pytest.approx(0.0, abs=1e-6),)


def test_torque_between_samples_is_lost():
    """At 50 samples instead of 100 the 30th harmonic is aliased: its peaks are lost."""
    (change,) = effects_of(np.cos(PHASE) + 0.2 * np.cos(30 * PHASE + 1.0), 100.0)
    assert abs(change) > 0.02


def test_failure_with_half_the_samples_is_full_effect():
    def refuses(_):
        raise DataError("too few")

    assert effects_of(np.cos(PHASE), 100.0, refuses) == (pytest.approx(-1.0),)
