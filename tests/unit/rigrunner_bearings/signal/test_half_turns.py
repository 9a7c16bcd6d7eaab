"""Sums over half turns give the same results as the half turns themselves."""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner_bearings.signal import half_turns
from rigrunner_bearings.signal.half_turns import HalfTurns, HalfTurnSums
from rigrunner_bearings.signal.kinematics import swing_angle

RATIO = 2 / 45


@pytest.mark.parametrize("together", [1, 5000, 1 << 16])
def test_sums_give_same_results_as_all_samples(monkeypatch, together):
    monkeypatch.setattr(half_turns, "TOGETHER", together)
    rng = np.random.default_rng(1)
    angle = swing_angle(2 * np.pi * np.arange(12_000) / 970.3, 1.01 * RATIO) + 0.001
    angle += 0.01 * RATIO * rng.standard_normal(len(angle))
    starts = 970.3 * np.arange(13) + rng.uniform(-3, 3, 13)
    arguments = (angle, starts, np.gradient(starts), 250, RATIO)  # both ends are outside in part
    turns, sums = HalfTurns.around(*arguments), HalfTurnSums.around(*arguments)
    scale = turns.scale(0.001)
    assert sums.scale(0.001) == pytest.approx(scale, rel=1e-13)
    late = turns.late(0.001, scale)
    np.testing.assert_allclose(sums.late(0.001, scale), late, rtol=0, atol=1e-11)
    assert np.abs(late).max() > 1
