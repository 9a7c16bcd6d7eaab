from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rigrunner.api.filters import LowPass
from rigrunner_bearings.compensations.drive_line import (
    HARMONICS,
    MAX_GAIN,
    TAPER,
    TWIST_HARMONICS,
    DriveLine,
)
from rigrunner_bearings.compensations.response import Waveform, raised_cosine
from rigrunner_bearings.compensations.swing import make_swing

SWING = make_swing(2 / 45, 1024)
NO_FILTER = LowPass(corner="1000 kHz")
LINE = DriveLine(400.0, 0.05, 0.0023, 1.0, 0.0, NO_FILTER)
FREQUENCY = 35.0


def driven_with_friction_pulse():
    """Integrate J th'' = k (drive - th) + c (drive' - th') - F over cycles, until it repeats."""
    stiffness = LINE.inertia_kgm2 * (2 * np.pi * LINE.natural_hz) ** 2
    damping = 2 * LINE.damping_ratio * np.sqrt(stiffness * LINE.inertia_kgm2)
    phase = 2 * np.pi * np.arange(SWING.size + 1) / SWING.size
    acceleration = FREQUENCY**2 * np.append(
        SWING.acceleration_per_hz2, SWING.acceleration_per_hz2[0]
    )
    friction = 0.7 * np.tanh(8 * np.sin(phase + 1.0))

    def derivative(time, state):
        now = (2 * np.pi * FREQUENCY * time) % (2 * np.pi)
        twist, rate = state
        torque = stiffness * twist + damping * rate - np.interp(now, phase, friction)
        return [rate, np.interp(now, phase, acceleration) - torque / LINE.inertia_kgm2]

    cycles = 6
    times = (cycles - 1 + np.arange(SWING.size) / SWING.size) / FREQUENCY
    solution = solve_ivp(
        derivative, (0, cycles / FREQUENCY), [0, 0], t_eval=times, max_step=1e-4, rtol=1e-8
    )
    twist, rate = solution.y
    return stiffness * twist + damping * rate, twist, friction[:-1]


def test_inverts_time_domain_oscillator():
    sensor, twist, friction = driven_with_friction_pulse()
    line = replace(LINE, harmonics=60)
    load_nm = line.at_load(Waveform(sensor), FREQUENCY)
    inertial = line.inertia_kgm2 * SWING.acceleration_per_hz2 * FREQUENCY**2
    low = np.abs(np.fft.rfft(load_nm - inertial - friction))[:20] * 2 / SWING.size
    assert np.abs(sensor - inertial - friction).max() > 0.2, "there is something to undo"
    assert low.max() < 1e-3
    np.testing.assert_allclose(line.twist(Waveform(sensor), FREQUENCY), twist, atol=2e-6)


def test_inverts_filter_and_delay():
    line = replace(LINE, low_pass=LowPass(order=3, corner="300 Hz"), delay_s=1e-4)
    phase = 2 * np.pi * np.arange(512) / 512
    at_load = np.cos(phase + 0.3) + 0.2 * np.sin(7 * phase)
    sensor = np.fft.irfft(np.fft.rfft(at_load) * line.sensor(np.arange(257) * 20.0), 512)
    np.testing.assert_allclose(line.at_load(Waveform(sensor), 20.0), at_load, atol=1e-12)


def test_delay_gives_negative_phase():
    line = replace(LINE, delay_s=1e-3)
    assert np.angle(line.channel(np.array([10.0])))[0] == pytest.approx(-2 * np.pi * 0.01, rel=1e-3)


def test_inversion_stops_where_it_would_amplify_noise():
    line = replace(LINE, natural_hz=150.0, low_pass=LowPass(corner="100 Hz"))
    impulse = np.zeros(1024)
    impulse[0] = 1.0
    assert np.abs(np.fft.rfft(line.at_load(Waveform(impulse), 35.0))).max() < 8
    assert np.abs(np.fft.rfft(line.at_load(Waveform(impulse), 35.0)))[30:].max() == pytest.approx(
        0, abs=1e-9
    )


def test_leading_dimensions_are_waveforms():
    waveforms = np.random.default_rng(1).standard_normal((3, 256))
    together = LINE.at_load(Waveform(waveforms), 10.0)
    np.testing.assert_allclose(together[1], LINE.at_load(Waveform(waveforms[1]), 10.0), atol=1e-12)


@pytest.mark.parametrize("harmonics", [19, 24, 60])
@pytest.mark.parametrize("size", [32, 4096])
def test_skipping_tapered_harmonics_changes_nothing(harmonics, size):
    waveform = np.random.default_rng(2).standard_normal(size)
    line = replace(LINE, harmonics=harmonics, low_pass=LowPass(corner="900 Hz"), delay_s=1e-5)
    harmonics_hz = np.arange(size // 2 + 1) * FREQUENCY

    def full_inverse(response, limit, share):
        too_little = np.flatnonzero(np.abs(response[:limit]) < 1 / MAX_GAIN)
        band = share * (float(too_little[0]) if len(too_little) else float(limit))
        taper = raised_cosine(np.arange(len(response), dtype=float), band, TAPER * band)
        return np.divide(taper, response, out=np.zeros_like(response), where=taper > 0)

    spectrum = np.fft.rfft(waveform)
    full = full_inverse(line.sensor(harmonics_hz), HARMONICS, harmonics / HARMONICS)
    assert np.array_equal(
        line.at_load(Waveform(waveform), FREQUENCY), np.fft.irfft(spectrum * full, size)
    )
    full = full_inverse(line.channel(harmonics_hz), TWIST_HARMONICS, 1.0) / line.stiffness(
        harmonics_hz
    )
    assert np.array_equal(
        line.twist(Waveform(waveform), FREQUENCY), np.fft.irfft(spectrum * full, size)
    )
