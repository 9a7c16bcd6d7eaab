import numpy as np
import pytest

from rigrunner_bearings.compensations.bearing import Reversals
from rigrunner_bearings.compensations.evaluation import noise_bias

N, CYCLES = 400, 30
WHERE = Reversals(np.arange(20, 120), np.arange(220, 320))


def without_each(noise):
    """Return leave-one-out means of cycles of noise (cycles, n), about the mean's error."""
    return (noise.sum(axis=0) - noise) / (len(noise) - 1)


def cycles(seed, u):
    """Return independent noise of which the mean over the cycles errs by u at each sample."""
    return u * np.sqrt(CYCLES) * np.random.default_rng(seed).standard_normal((CYCLES, N))


@pytest.mark.parametrize("u", [0.01, 0.03])
def test_flat_torque_reads_high_by_the_expected_extreme(u):
    """The mean of the greatest of 100 normal values is 2.508 sigma (Tippett, 1925).

    The errors are in the curve once, and are added once more: so of a flat one sqrt 2 - 1 more.
    """
    flat = np.where(np.arange(N) < N / 2, 0.7, -0.7)
    biases = []
    for seed in range(20):
        noise = cycles(seed, u)
        curve = flat + noise.mean(axis=0)
        biases.append(noise_bias(curve, [flat + without_each(noise)], WHERE))
    assert np.mean(biases) == pytest.approx((np.sqrt(2) - 1) * 2.508 * u, rel=0.15)


def test_a_smooth_maximum_has_next_to_none():
    phase = np.arange(N) / N * 2 * np.pi
    smooth = np.sin(phase) * 0.7
    common = 0.01 * np.random.default_rng(1).standard_normal((CYCLES, 1)) * np.sin(phase)
    assert noise_bias(smooth, [smooth + without_each(common)], WHERE) == pytest.approx(0, abs=1e-12)


def test_both_runs_count_and_nothing_is_left_to_chance():
    flat = np.where(np.arange(N) < N / 2, 0.7, -0.7)
    one, other = (flat + without_each(cycles(seed, 0.01)) for seed in (1, 2))
    combined = noise_bias(flat, [one, other], WHERE)
    assert combined == pytest.approx(np.sqrt(2) * noise_bias(flat, [one], WHERE), rel=0.15)
    assert combined == noise_bias(flat, [one, other], WHERE)


def test_without_noise_there_is_none():
    flat = np.where(np.arange(N) < N / 2, 0.7, -0.7)
    assert noise_bias(flat, [np.tile(flat, (CYCLES, 1))], WHERE) == pytest.approx(0, abs=1e-15)
