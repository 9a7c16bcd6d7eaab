from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from helpers_rigs import IDEAL_SENSORS
from rigrunner_bearings.devices.simulated.parameters import ConstantErrors
from rigrunner_bearings.devices.simulated.sampling import (
    RigState,
    SimulatedRig,
    SteadyState,
    noise_source,
    sample,
)

RATIO = 2 / 45
PHASE = 2 * np.pi * np.arange(4096) / 4096
HARMONIC = 20


def _rig(**sensors):
    """A rig whose torque is one harmonic of the crank, its size the frequency."""
    return SimulatedRig(
        RATIO,
        lambda _load, hz: SteadyState(hz * np.cos(HARMONIC * PHASE)),
        replace(IDEAL_SENSORS, range_nm=100.0, **sensors),
    )


def _sample(rig, frequency_hz=10.0, samples=20_000, seed=0):
    state = RigState(frequency_hz, 0.0)
    return sample(rig, state, samples, ConstantErrors(), np.random.default_rng(seed))


def _component(torque, frequency_hz):
    """Complex amplitude at that frequency, over whole periods."""
    time = np.arange(len(torque)) / 10e3
    return 2 * np.mean(torque * np.exp(-2j * np.pi * frequency_hz * time))


def test_angle_and_torque_share_crank_phase():
    angle, torque = _sample(_rig())
    assert angle.max() == pytest.approx(np.arcsin(RATIO), rel=1e-4)
    turn = _component(angle, 10.0) / abs(_component(angle, 10.0)) * 1j
    assert _component(torque, 200.0) == pytest.approx(10 * turn**HARMONIC, abs=0.02)


def test_recordings_start_at_random_phase():
    starts = [_sample(_rig(), samples=1, seed=seed)[0][0] for seed in range(20)]
    assert np.std(starts) > 0.3 * RATIO


def test_low_pass_is_second_order_butterworth():
    _, torque = _sample(_rig(low_pass_hz=200.0))
    assert abs(_component(torque, 200.0)) == pytest.approx(10 / np.sqrt(2), rel=1e-3)
    _, far = _sample(_rig(low_pass_hz=50.0))
    assert abs(_component(far, 200.0)) == pytest.approx(10 / np.sqrt(1 + 4**4), rel=1e-3)


def test_cache_distinguishes_frequencies_and_filters():
    cycle = SteadyState(np.cos(HARMONIC * PHASE))

    def size(frequency_hz, low_pass_hz):
        rig = replace(_rig(low_pass_hz=low_pass_hz), steady_state=lambda *_: cycle)
        return abs(_component(_sample(rig, frequency_hz)[1], HARMONIC * frequency_hz))

    cases = [(10.0, 200.0), (10.0, 50.0), (5.0, 50.0)]
    expected = [1 / np.sqrt(1 + (HARMONIC * hz / corner) ** 4) for hz, corner in cases]
    assert [size(*case) for case in 2 * cases] == pytest.approx(2 * expected, rel=1e-3)


def test_delay_shifts_torque_against_angle():
    prompt_angle, prompt = _sample(_rig())
    late_angle, late = _sample(_rig(torque_delay_s=1e-3))
    assert np.array_equal(prompt_angle, late_angle)
    assert np.allclose(late[10:], prompt[:-10], atol=1e-3)


def test_frequency_error_shows_in_angle():
    angle, _ = _sample(_rig(frequency_error=0.05), samples=20_000)
    assert np.argmax(np.abs(np.fft.rfft(angle))) == 21  # cycles in 2 s


def test_speed_jitter_varies_period_and_torque_of_each_turn():
    jitter = 0.01
    angle, torque = _sample(_rig(speed_jitter=jitter), samples=400_000)
    marks = np.flatnonzero((angle[:-1] < 0) & (angle[1:] >= 0))
    exact = marks - angle[marks] / (angle[marks + 1] - angle[marks])
    period = np.diff(exact) / 10e3
    assert (1 / period).std() == pytest.approx(0.1, rel=0.15)
    heights = [abs(torque[a + 20 : b - 20]).max() for a, b in pairwise(marks)]
    assert np.corrcoef(heights, 1 / period)[0, 1] > 0.9
    assert np.std(heights) == pytest.approx(10 * jitter, rel=0.15)


def test_without_jitter_all_turns_are_equal():
    angle, _ = _sample(_rig(), samples=3000)
    assert np.allclose(angle[:1000], angle[1000:2000], atol=1e-12)


def test_rig_at_rest_has_no_swing_and_no_torque():
    angle, torque = _sample(_rig(), frequency_hz=0.0)
    assert not angle.any()
    assert not torque.any()


def test_noise_depends_on_seed_set_points_and_repetition():
    def first(*arguments):
        return noise_source(*arguments).standard_normal()

    state = RigState(10.0, 1000.0, 5.0)
    assert first(1, state, 0) == first(1, replace(state, elapsed_s=99.0), 0)
    others = [
        first(2, state, 0),
        first(1, state, 1),
        first(1, replace(state, load_n=0.0), 0),
        first(1, replace(state, frequency_hz=10.1), 0),
    ]
    assert len({first(1, state, 0), *others}) == 5
