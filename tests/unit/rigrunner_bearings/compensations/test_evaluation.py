import numpy as np
import pytest

from rigrunner_bearings.compensations.bearing import Reversals
from rigrunner_bearings.compensations.evaluation import noise_bias

N, CYCLES = 400, 30
WHERE = Reversals(np.arange(20, 120), np.arange(220, 320))


def leave_one_out(noise):
    """Return leave-one-out means of cycles of noise (cycles, n), about the mean's error."""
    return (noise.sum(axis=0) - noise) / (len(noise) - 1)


def cycles(seed, u):
    """Return independent noise whose mean over the cycles has the uncertainty u at each sample."""
    return u * np.sqrt(CYCLES) * np.random.default_rng(seed).standard_normal((CYCLES, N))


@pytest.mark.parametrize("u", [0.01, 0.03])
def test_flat_torque_reads_high_by_the_expected_extreme(u):
    """The mean of the greatest of 100 normal values is 2.508 sigma (Tippett, 1925).

    The curve has the errors once and the replicates add them again: a flat one has sqrt 2 - 1 more.
    """
    flat = np.where(np.arange(N) < N / 2, 0.7, -0.7)
    biases = []
    for seed in range(20):
        noise = cycles(seed, u)
        curve = flat + noise.mean(axis=0)
        biases.append(noise_bias(curve, [flat + leave_one_out(noise)], WHERE))
    assert np.mean(biases) == pytest.approx((np.sqrt(2) - 1) * 2.508 * u, rel=0.15)


def test_smooth_maximum_has_no_bias():
    phase = np.arange(N) / N * 2 * np.pi
    smooth = np.sin(phase) * 0.7
    common = 0.01 * np.random.default_rng(1).standard_normal((CYCLES, 1)) * np.sin(phase)
    assert noise_bias(smooth, [smooth + leave_one_out(common)], WHERE) == pytest.approx(
        0, abs=1e-12
    )


def test_both_runs_contribute_and_bias_is_deterministic():
    flat = np.where(np.arange(N) < N / 2, 0.7, -0.7)
    one, other = (flat + leave_one_out(cycles(seed, 0.01)) for seed in (1, 2))
    combined = noise_bias(flat, [one, other], WHERE)
    assert combined == pytest.approx(np.sqrt(2) * noise_bias(flat, [one], WHERE), rel=0.15)
    assert combined == noise_bias(flat, [one, other], WHERE)


def test_without_noise_there_is_no_bias():
    flat = np.where(np.arange(N) < N / 2, 0.7, -0.7)
    assert noise_bias(flat, [np.tile(flat, (CYCLES, 1))], WHERE) == pytest.approx(0, abs=1e-15)
