from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner_bearings.api.points import MotionSource, SwingPoint
from rigrunner_bearings.signal.kinematics import angular_velocity
from rigrunner_bearings.torque.checks import motion_check
from rigrunner_bearings.torque.prepare import prepare_point
from unit.analysis.helpers_analysis import RATE_HZ, RATIO, RIG_KEYS, recording, run_of, spec

PEAKS = np.linspace(1.9, 2.1, 12)
HERTZ = 7.3


def phase_of(rec):
    """Return the crank phase of `recording`, which starts 0.4 of a turn early."""
    return 2 * np.pi * np.arange(-0.4, len(PEAKS) + 0.4, HERTZ / RATE_HZ)[: rec.samples]


def recording_with(channel, unit, values_of):
    """Return the recording with `channel` in place of its angle."""
    rec = recording(PEAKS, HERTZ)
    values = values_of(phase_of(rec))
    torque = rec.channels["tester.torque"]
    return replace(
        rec,
        channels={"tester.torque": torque, channel: values},
        units={"tester.torque": "N·m", channel: unit},
    )


def by_index(at_rad=0.0):
    return recording_with(
        "tester.index", "1", lambda phase: ((phase - at_rad) % (2 * np.pi) < 0.3).astype(float)
    )


def by_tacho(offset=0.0):
    return recording_with(
        "tester.velocity", "rad/s", lambda phase: angular_velocity(phase, HERTZ, RATIO) + offset
    )


def prepared(rec, **rig):
    run = run_of(rec, rig_keys=RIG_KEYS | rig)
    return prepare_point(rec, run, spec(), lambda _: [])


def phase_error_rad(point):
    """Return how far the first harmonic of cos(phi - 60 deg) is off."""
    mean = point.torque_nm.mean(axis=0)
    return float(np.angle(np.fft.rfft(mean)[1]) + np.pi / 3)


@pytest.mark.parametrize(
    ("rec", "source"), [(by_index(), MotionSource.INDEX), (by_tacho(), MotionSource.TACHO)]
)
def test_index_and_tacho_give_frequency_phase_and_swings(rec, source):
    point = prepared(rec)
    assert isinstance(point, SwingPoint)
    assert point.motion is source
    assert point.frequency_hz.value == pytest.approx(HERTZ, rel=3e-4)
    assert abs(point.frequency_hz.value - HERTZ) < 3 * point.frequency_hz.u + 1e-6
    # half a sample is 0.0115 rad at 274 samples a cycle
    assert phase_error_rad(point) == pytest.approx(0, abs=0.012)
    assert point.angle_rad.max() == pytest.approx(np.arcsin(RATIO), rel=1e-3)
    assert point.peak_nm == pytest.approx(PEAKS[: point.cycles], rel=3e-4)


def test_station_states_index_phase():
    point = prepared(by_index(at_rad=1.1), index_phase="1.1 rad")
    assert phase_error_rad(point) == pytest.approx(0, abs=0.012)
    wrong = prepared(by_index(at_rad=1.1))
    assert phase_error_rad(wrong) == pytest.approx(1.1, abs=0.02)


def test_tacho_offset_does_not_matter():
    plain, offset = prepared(by_tacho()), prepared(by_tacho(offset=0.3))
    assert phase_error_rad(offset) == pytest.approx(phase_error_rad(plain), abs=2e-3)
    assert offset.angle_rad == pytest.approx(plain.angle_rad, abs=2e-4)


def test_tacho_scale_does_not_affect_phase():
    rec = by_tacho()
    doubled = dict(rec.channels) | {"tester.velocity": 1.3 * rec.channels["tester.velocity"]}
    assert phase_error_rad(prepared(replace(rec, channels=doubled))) == pytest.approx(0, abs=1e-3)


def test_phase_of_index_and_tacho_is_uncertain():
    tolerance = np.deg2rad(2.0)
    index = prepared(by_index(), phase_tolerance="2 deg")
    tacho = prepared(by_tacho(), phase_tolerance="2 deg")
    assert index.phase_common_u_rad == pytest.approx(tolerance / np.sqrt(3))
    assert tacho.phase_common_u_rad == pytest.approx(tolerance / np.sqrt(3))
    # +/- half a sample, rectangular, of 2 pi f / rate a sample
    assert index.phase_u_rad == pytest.approx(np.pi * HERTZ / RATE_HZ / np.sqrt(3), rel=1e-3)
    assert prepared(recording(PEAKS)).phase_common_u_rad == 0.0


def test_angle_is_preferred_to_tacho_and_tacho_to_index():
    angle, tacho, index = recording(PEAKS, HERTZ), by_tacho(), by_index()
    two = replace(
        tacho,
        channels=dict(index.channels) | tacho.channels,
        units=dict(index.units) | tacho.units,
    )
    assert prepared(two).motion is MotionSource.TACHO
    three = replace(
        angle, channels=dict(two.channels) | angle.channels, units=dict(two.units) | angle.units
    )
    assert prepared(three).motion is MotionSource.ANGLE


def test_tacho_of_crank_is_refused():
    rec = recording_with("tester.velocity", "rad/s", lambda phase: np.full(len(phase), 45.9))
    with pytest.raises(DataError, match=r"tester\.velocity: the velocity never changes its sign"):
        prepared(rec)


def test_missing_index_pulses_name_recording_and_channel():
    rec = recording_with("tester.index", "1", np.zeros_like)
    with pytest.raises(DataError, match=r"recording 7\.3Hz, tester\.index: 0 pulses"):
        prepared(rec)


def test_four_cycles_by_entered_frequency_are_refused():
    rec = recording(PEAKS[:4])
    bare = replace(rec, channels={"tester.torque": rec.channels["tester.torque"]})
    with pytest.raises(DataError, match=r"tester\.torque: 4 whole cycles, but 5 are needed"):
        prepared(bare)


def test_substitute_for_angle_is_reported():
    assert motion_check([prepared(recording(PEAKS))]).ok
    index = motion_check([prepared(by_index())], "no-load run: ")
    assert (index.name, index.ok) == ("no-load run: angle channel", False)
    assert "one index pulse per cycle, with a larger uncertainty" in index.text
    assert "from the tacho" in motion_check([prepared(by_tacho())]).text
    rec = recording(PEAKS)
    bare = replace(rec, channels={"tester.torque": rec.channels["tester.torque"]})
    entered = motion_check([prepared(bare)])
    assert "cut by the entered frequency, and only peak methods apply" in entered.text
