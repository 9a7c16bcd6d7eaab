from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.data import Estimate
from rigrunner_bearings.signal.kinematics import swing_angle
from rigrunner_bearings.torque.checks import (
    friction_check,
    positive_check,
    run_checks,
    zero_drift_check,
)
from rigrunner_bearings.torque.prepare import prepare_point
from unit.analysis.helpers_analysis import RATIO, recording, run_of, spec, swing_point

PEAKS = np.linspace(1.99, 2.01, 12)


def checks(rec, prefix="", **changes):
    run = run_of(rec, **changes)
    point = prepare_point(rec, run, spec(despike=None), lambda _: [])
    return {check.name: check for check in run_checks(run, (point,), prefix)}


def with_torque(rec, change):
    torque = change(rec.channels["tester.torque"].copy())
    return replace(rec, channels=dict(rec.channels) | {"tester.torque": torque})


def entered(rec, frequency_hz):
    return replace(rec, setpoints=dict(rec.setpoints) | {"tester.frequency": frequency_hz})


def test_good_recording_passes_all_checks():
    by_name = checks(recording(PEAKS, 7.0))
    assert list(by_name) == [
        "angle channel",
        "entered frequency",
        "stroke",
        "steady speed",
        "clipping",
        "stuck torque",
        "range",
        "spikes",
        "cycles",
        "samples per cycle",
        "zero",
    ]
    assert all(check.ok and check.text and not check.advice for check in by_name.values())


def test_check_names_have_the_prefix():
    assert all(
        name.startswith("no-load run: ") for name in checks(recording(PEAKS), "no-load run: ")
    )


@pytest.mark.parametrize(("frequency_hz", "ok"), [(10.04, True), (10.06, False), (9.94, False)])
def test_entered_frequency_is_checked_to_half_a_percent(frequency_hz, ok):
    check = checks(entered(recording(PEAKS), frequency_hz))["entered frequency"]
    assert check.ok is ok
    if not ok:
        assert check.text == f"10Hz entered {frequency_hz:g} Hz, angle says 10 Hz"
        assert check.advice


@pytest.mark.parametrize(
    ("scale", "ok"), [(1.0, True), (1.018, True), (1.022, False), (0.97, False)]
)
def test_stroke_is_checked_to_two_percent(scale, ok):
    rec = recording(PEAKS)
    turns = np.arange(-0.4, 12.4, 10 / 2000)
    swing = swing_angle(2 * np.pi * turns, RATIO * scale)
    other_stroke = replace(rec, channels=dict(rec.channels) | {"tester.angle": swing})
    assert checks(other_stroke)["stroke"].ok is ok


def test_equal_samples_at_extreme_are_clipping():
    clipped = with_torque(recording(PEAKS), lambda torque: np.minimum(torque, 1.9))
    check = checks(clipped)["clipping"]
    assert not check.ok
    assert "equal samples" in check.text


def test_equal_samples_at_minimum_are_clipping():
    assert not checks(with_torque(recording(PEAKS), lambda t: np.maximum(t, -1.9)))["clipping"].ok


def test_two_equal_samples_are_not_clipping():
    def two_equal(torque):
        top = torque.argmax()
        torque[top + 1] = torque[top]
        return torque

    assert checks(with_torque(recording(PEAKS), two_equal))["clipping"].ok


def stuck_from(begin, count):
    def change(torque):
        torque[begin : begin + count] = torque[begin]
        return torque

    return change


@pytest.mark.parametrize(("count", "ok"), [(6, True), (7, False), (200, False), (800, False)])
def test_temporarily_stuck_torque_is_flagged(count, ok):
    """2 are usual, three times as many are allowed; a cycle has 200 samples."""
    check = checks(with_torque(recording(PEAKS), stuck_from(700, count)))["stuck torque"]
    assert check.ok is ok
    assert ok or check.text == f"10Hz keeps one value for {count} samples, 2 are usual"


def test_permanently_stuck_torque_is_flagged():
    check = checks(
        with_torque(recording(PEAKS), lambda t: np.where(np.arange(len(t)) > 30, 0.5, t))
    )
    assert not check["stuck torque"].ok


def test_repeated_values_in_every_cycle_are_not_stuck():
    """Steps of 0.2 N·m repeat near each extreme of 2 N·m; a slow logger repeats each sample."""
    coarse = with_torque(recording(PEAKS), lambda torque: np.round(torque / 0.2) * 0.2)
    assert checks(coarse)["stuck torque"].ok
    slow = with_torque(recording(PEAKS), lambda torque: np.repeat(torque[::10], 10)[: len(torque)])
    assert checks(slow)["stuck torque"].ok
    assert not checks(with_torque(slow, stuck_from(700, 40)))["stuck torque"].ok


def test_torque_near_full_scale_is_flagged():
    assert checks(recording(PEAKS * 4.7))["range"].ok  # 9.45 of 10 N·m
    check = checks(recording(PEAKS * 4.78))["range"]  # 9.61
    assert not check.ok
    assert check.text == "10Hz reaches 96 % of 10 N·m"
    assert (check.value, check.threshold, check.unit) == (pytest.approx(96.1, abs=0.05), 95.0, "%")


def test_single_spike_beyond_full_scale_is_not_flagged():
    def spike(torque):
        torque[777] = 11.0
        return torque

    assert checks(with_torque(recording(PEAKS), spike))["range"].ok


@pytest.mark.parametrize(("jitter", "ok"), [(0.0, True), (4e-4, True), (7e-4, False)])
def test_scattered_speed_is_flagged(jitter, ok):
    """Twelve cycles, each faster or slower than 10 Hz by the jitter: s = jitter sqrt(12/11)."""
    point = swing_point(PEAKS, 10.0)
    scatter = jitter * 10.0 * np.sqrt(12 / 11)
    point = replace(point, frequency_hz=Estimate(10.0, scatter / np.sqrt(12), 11.0, "Hz"))
    by_name = {check.name: check for check in run_checks(run_of(recording(PEAKS)), (point,))}
    assert by_name["steady speed"].ok is ok
    assert by_name["steady speed"].value == pytest.approx(100 * jitter * np.sqrt(12 / 11))


@pytest.mark.parametrize(("frequency_hz", "ok"), [(7.0, True), (7.2, False)])
def test_few_samples_per_cycle_are_flagged(frequency_hz, ok):
    """At 2 kHz, 280 samples are 7.14 Hz."""
    check = checks(recording(PEAKS, frequency_hz))["samples per cycle"]
    assert check.ok is ok
    assert check.value == pytest.approx(2000 / frequency_hz, rel=1e-3)


def test_run_without_load_has_no_friction_coefficient():
    check = friction_check([(10.0, 0.7)], [0.0], 0.0104)
    assert check.ok
    assert check.text == "not checked: the run has no load"


@pytest.mark.parametrize(("spikes", "ok"), [(12, True), (13, False)])
def test_more_than_one_spike_per_cycle_is_flagged(spikes, ok):
    point = replace(swing_point(PEAKS, 10.0), spikes=spikes)
    by_name = {check.name: check for check in run_checks(run_of(recording(PEAKS)), (point,))}
    assert by_name["spikes"].ok is ok


@pytest.mark.parametrize(("cycles", "ok"), [(9, False), (10, True)])
def test_few_cycles_are_flagged(cycles, ok):
    assert checks(recording(PEAKS[:cycles]))["cycles"].ok is ok


def test_missing_zero_is_flagged():
    check = checks(recording(PEAKS), zeros={})["zero"]
    assert not check.ok
    assert check.text == "tester.torque"


@pytest.mark.parametrize(("zero_nm", "ok"), [(0.019, True), (0.021, False), (-0.021, False)])
def test_zero_drift_between_runs_is_flagged(zero_nm, ok):
    run = run_of(zeros={"tester.torque": 0.5 + zero_nm})
    assert zero_drift_check(run, run_of(zeros={"tester.torque": 0.5})).ok is ok


@pytest.mark.parametrize(
    ("torque_nm", "ok"), [(0.73, True), (0.11, True), (0.10, False), (3.13, False), (3.11, True)]
)
def test_implausible_friction_coefficient_is_flagged(torque_nm, ok):
    """F r = 1000 N * 10.4 mm = 10.4 N·m: 0.01 and 0.3 of it are 0.104 and 3.12 N·m."""
    assert friction_check([(10.0, torque_nm)], [1000.0], 0.0104).ok is ok


def test_friction_coefficients_under_several_loads():
    """Half of the torque under half of the load is the same coefficient."""
    check = friction_check([(10.0, 0.26), (10.0, 2.6)], [100.0, 1000.0], 0.0104)
    assert (check.ok, check.value) == (True, pytest.approx(0.25))


@pytest.mark.parametrize(("torque_nm", "ok"), [(0.1, True), (0.0, False), (-0.1, False)])
def test_torque_must_be_positive(torque_nm, ok):
    assert positive_check([(10.0, torque_nm), (20.0, 0.7)]).ok is ok
