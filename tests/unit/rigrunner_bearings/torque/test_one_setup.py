from __future__ import annotations

from dataclasses import replace

import pytest

from rigrunner.api.analysis import Bias
from rigrunner.api.data import Estimate
from rigrunner.api.filters import LowPass
from rigrunner.api.quantity import parse_quantity
from rigrunner_bearings.api.compensations import CompensatedPoint
from rigrunner_bearings.torque.one_setup import setup_check, unloaded_check
from unit.analysis.helpers_analysis import RIG_KEYS, instrument, run_of, swing_point

CHANNEL = "tester.torque"
PEAKS = [1.0] * 6


def with_transducer(**changes):
    return run_of(instruments={CHANNEL: instrument().model_copy(update=changes)})


def test_same_register_is_one_setup():
    check = setup_check(run_of(), run_of())
    assert check.ok
    assert check.decisive


@pytest.mark.parametrize(
    ("no_load", "words"),
    [
        (with_transducer(serial="T-2"), "its torque transducer is 'T-2', but 'T-1' is needed"),
        (with_transducer(certificate="C-8"), "its transducer's certificate is 'C-8', but ''"),
        (
            with_transducer(full_scale_=parse_quantity("20 N·m")),
            "its full scale is '20 N·m', but '10 N·m'",
        ),
        (
            with_transducer(low_pass=None),
            "its low-pass filter is 'none', but 'butterworth, order 2, 1000",
        ),
        (
            with_transducer(low_pass=LowPass(corner="300 Hz")),
            "its low-pass filter is 'butterworth, order 2, 300 Hz'",
        ),
        (
            run_of(rig_keys=RIG_KEYS | {"eccentric": "3 mm"}),
            "its eccentric is 3 mm, but 2 mm is needed",
        ),
    ],
)
def test_different_transducer_filter_or_swing_is_not_one_setup(no_load, words):
    check = setup_check(run_of(), no_load)
    assert not check.ok
    assert words in check.text


def test_channel_of_one_run_only_is_not_compared():
    assert setup_check(run_of(), run_of(instruments={})).ok


@pytest.mark.parametrize(("load_n", "ok"), [(0.0, True), (9.9, True), (-10.1, False), (100, False)])
def test_loaded_no_load_run_is_flagged(load_n, ok):
    """1 % of 1000 N is 10 N: the torque is too low by 1 %."""
    loaded, no_load = swing_point(PEAKS, 10.0), swing_point(PEAKS, 10.0, load_n=load_n)
    check = unloaded_check([loaded], [no_load], ())
    assert check.ok is ok
    assert ok or check.text == f"10Hz was made under {load_n:.4g} N"


def test_residual_load_is_compared_with_smallest_load():
    loaded = [swing_point(PEAKS, 10.0), swing_point(PEAKS, 20.0, load_n=100.0)]
    assert not unloaded_check(loaded, [replace(loaded[0], load_n=2.0)], ()).ok


def test_unloaded_run_is_not_checked():
    point = swing_point(PEAKS, 10.0, load_n=0.0)
    assert unloaded_check([point], [point], ()).text == "not checked: the run has no load"


def test_residual_load_reduces_torque_in_proportion():
    """By Coulomb's law: 3 % of the load, 3 % of the torque."""
    loaded, no_load = swing_point([1.0, 1.1], 5.0, load_n=1000.0), swing_point([0.5, 0.5], 5.0)
    point = CompensatedPoint(5.0, 5.0, 1.0, 0.2, Estimate(0.8, 0.01), ())
    check = unloaded_check([loaded], [replace(no_load, load_n=30.0)], [point])
    assert not check.ok
    assert check.biases == (Bias("5 Hz", pytest.approx(-0.024), pytest.approx(0.012)),)
