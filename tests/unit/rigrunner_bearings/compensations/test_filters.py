"""Responses of filters against scipy's design of them, and against their definitions."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy import signal
from scipy.optimize import brentq

from rigrunner.api.filters import AnyFilter
from rigrunner_bearings.compensations.filters import corner_hz, response_of

FILTER = TypeAdapter(AnyFilter)
HZ = np.array([0.0, 1.0, 35.0, 210.0, 499.0, 500.0, 800.0, 2500.0])


def filter_of(**described):
    return FILTER.validate_python(described)


@pytest.mark.parametrize("order", range(1, 9))
def test_bessel_equals_scipy(order):
    numerator, denominator = signal.bessel(order, 1.0, analog=True, norm="mag")
    expected = signal.freqs(numerator, denominator, HZ / 500)[1]
    low_pass = filter_of(type="bessel", order=order, corner="500 Hz")
    np.testing.assert_allclose(response_of(low_pass, HZ), expected, atol=1e-10)


@pytest.mark.parametrize("ripple_db", [0.1, 0.5, 3.0])
@pytest.mark.parametrize("order", range(1, 9))
def test_chebyshev_equals_scipy(order, ripple_db):
    """Scipy puts the corner at the end of the ripple, so its 3 dB point is searched for."""
    numerator, denominator = signal.cheby1(order, ripple_db, 1.0, analog=True)
    at_rest = abs(signal.freqs(numerator, denominator, [0.0])[1][0])

    def above_half(w):
        return abs(signal.freqs(numerator, denominator, [w])[1][0]) - at_rest / np.sqrt(2)

    half = brentq(above_half, 0.999, 1000, xtol=1e-15)
    expected = signal.freqs(numerator, denominator, HZ / 500 * half)[1] / at_rest
    low_pass = filter_of(type="chebyshev", order=order, corner="500 Hz", ripple_db=ripple_db)
    np.testing.assert_allclose(response_of(low_pass, HZ), expected, atol=1e-9)


@pytest.mark.parametrize("kind", [{}, {"type": "bessel"}, {"type": "chebyshev", "ripple_db": 1.0}])
def test_gain_at_corner_is_minus_3_db(kind):
    low_pass = filter_of(order=4, corner="500 Hz", **kind)
    assert abs(response_of(low_pass, HZ))[5] == pytest.approx(1 / np.sqrt(2), rel=1e-9)
    assert corner_hz(low_pass) == 500
    assert corner_hz(low_pass.scaled(1.02)) == pytest.approx(510)


def test_taps_give_filter_with_delay():
    """The mean of four samples: Dirichlet's kernel, and a delay of one and a half samples."""
    low_pass = filter_of(type="fir", taps=[2.0, 2.0, 2.0, 2.0], rate="8 kHz")
    hertz = np.array([50.0, 900.0, 3000.0])
    turn = np.pi * hertz / 8000
    expected = np.sin(4 * turn) / (4 * np.sin(turn)) * np.exp(-3j * turn)
    np.testing.assert_allclose(response_of(low_pass, hertz), expected, atol=1e-13)
    corner = corner_hz(low_pass)
    assert abs(np.sin(4 * np.pi * corner / 8000) / (4 * np.sin(np.pi * corner / 8000))) == (
        pytest.approx(1 / np.sqrt(2), rel=1e-9)
    )
    assert corner_hz(low_pass.scaled(2)) == pytest.approx(2 * corner)


def test_measured_response_passes_through_its_points():
    """A Butterworth filter, measured every 20 Hz, is that filter between the points and beyond."""
    truth = filter_of(order=2, corner="500 Hz")
    hertz = np.arange(20.0, 2001.0, 20.0)
    table = [
        {"frequency": f"{f} Hz", "gain": float(abs(h)), "phase": f"{float(np.angle(h))!r} rad"}
        for f, h in zip(hertz, response_of(truth, hertz), strict=True)
    ]
    low_pass = filter_of(type="measured", response=table, source="own measurement of 2026-11-02")
    np.testing.assert_allclose(response_of(low_pass, hertz), response_of(truth, hertz), rtol=1e-12)
    between = np.array([7.0, 333.0, 1234.0, 3000.0])
    np.testing.assert_allclose(
        np.abs(response_of(low_pass, between)), np.abs(response_of(truth, between)), rtol=0.02
    )
    np.testing.assert_allclose(
        response_of(low_pass, between), response_of(truth, between), atol=5e-3
    )
    assert response_of(low_pass, np.array(0.0)) == 1
    assert corner_hz(low_pass) == pytest.approx(500, rel=1e-3)
    assert corner_hz(low_pass.scaled(1.1)) == pytest.approx(550, rel=1e-3)


POINT = {"frequency": "10 Hz", "gain": 1.0, "phase": "0 rad"}


@pytest.mark.parametrize(
    ("described", "message"),
    [
        ({"type": "elliptic", "corner": "1 kHz"}, "'butterworth', 'bessel' or 'chebyshev'"),
        ({"type": "chebyshev", "corner": "1 kHz"}, "chebyshev needs it"),
        ({"type": "bessel", "corner": "1 kHz", "ripple_db": 1.0}, "ripple_db belongs to chebyshev"),
        ({"type": "fir", "taps": [1.0, -1.0], "rate": "1 kHz"}, "taps add up to 0"),
        ({"type": "fir", "taps": [], "rate": "1 kHz"}, "at least 1 item"),
        ({"type": "measured", "response": [POINT], "source": "us"}, "at least 2 items"),
        ({"type": "measured", "response": [POINT, POINT], "source": "us"}, "must ascend"),
        ({"type": "measured", "response": [POINT, POINT]}, "source"),
    ],
)
def test_invalid_filter_is_refused(described, message):
    with pytest.raises(ValidationError, match=message):
        filter_of(**described)
