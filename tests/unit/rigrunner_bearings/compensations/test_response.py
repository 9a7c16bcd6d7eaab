import numpy as np
import pytest
from scipy import signal

from rigrunner_bearings.compensations.response import (
    apply,
    butterworth,
    inverse,
    raised_cosine,
    torsional_resonance,
)

HZ = np.linspace(0, 3000, 301)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5, 8])
def test_butterworth_equals_scipy(order):
    b, a = signal.butter(order, 2 * np.pi * 1000, analog=True)
    _, expected = signal.freqs(b, a, 2 * np.pi * HZ)
    np.testing.assert_allclose(butterworth(HZ, 1000, order), expected, atol=1e-12)


def test_resonance_equals_base_driven_oscillator():
    """Transmitted torque of k and c over the load on J, from the equation of motion."""
    j, natural, damping = 0.0023, 400.0, 0.05
    k, s = j * (2 * np.pi * natural) ** 2, 2j * np.pi * HZ
    c = 2 * damping * np.sqrt(k * j)
    expected = (k + c * s) / (j * s**2 + c * s + k)
    np.testing.assert_allclose(torsional_resonance(HZ, natural, damping), expected, rtol=1e-12)


def test_taper_is_flat_then_zero():
    taper = raised_cosine(HZ, 600, 900)
    assert np.all(taper[HZ <= 600] == 1)
    assert np.all(taper[HZ >= 900] == 0)
    assert taper[HZ == 750] == pytest.approx(0.5)


def test_inverse_times_response_is_one_in_band():
    through = torsional_resonance(HZ, 400, 0.05)
    undone = through * inverse(through, raised_cosine(HZ, 600, 900))
    np.testing.assert_allclose(undone[HZ <= 600], 1)
    assert np.all(undone[HZ >= 900] == 0)


def test_inverse_ignores_zeros_outside_taper():
    assert inverse(np.array([1.0 + 0j, 0.0]), np.array([1.0, 0.0])).tolist() == [1, 0]


def test_apply_filters_each_harmonic():
    phase = 2 * np.pi * np.arange(64) / 64
    response = np.zeros(33, complex)
    response[3] = 2 * np.exp(1j * 0.5)
    waveforms = np.stack([np.cos(3 * phase) + np.cos(5 * phase), np.sin(3 * phase)])
    expected = np.stack([2 * np.cos(3 * phase + 0.5), 2 * np.sin(3 * phase + 0.5)])
    np.testing.assert_allclose(apply(response, waveforms), expected, atol=1e-12)
