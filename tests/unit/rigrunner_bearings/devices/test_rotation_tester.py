"""The simulated bench for slow rotation: starts from rest, ageing at rest, running in."""

from __future__ import annotations

import threading
from math import log10, pi
from pathlib import Path

import numpy as np
import pytest

from rigrunner.api.devices import DeviceContext
from rigrunner.api.errors import DeviceNotFoundError, PluginError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry

QUIET = {
    "noise": "0 N·m", "gain": "0 %", "offset": "0 N·m", "drift": "0 N·m", "nonlinearity": "0 %",
    "encoder_resolution": "0 deg",
}  # fmt: skip
EXACT = {"scatter": "0 %", "fresh_excess": "0 %"}
RPM_HZ = 1 / 60


class Bench:
    """The device with a clock that advances only by sleep() and while streaming."""

    def __init__(self, bearing=None, sensors=None, **settings):
        self.clock = SimulatedClock()
        context = DeviceContext("bench", self.clock, Path())
        settings |= {"bearing": bearing or {}, "sensors": sensors or {}}
        self.device = load_registry().make("device", "rotation_tester_sim", settings, context)
        self.device.connect(1.0)

    def stream(self, duration_s=1.0):
        blocks = list(self.device.stream(["angle", "torque"], duration_s, threading.Event()))
        return (np.concatenate([b.channels[n] for b in blocks]) for n in ("angle", "torque"))

    def start(self, rest_s, frequency_hz=2 * RPM_HZ, duration_s=1.0):
        self.device.set("start_frequency", frequency_hz)
        self.clock.sleep(rest_s)
        return self.stream(duration_s)

    def truth_nm(self):
        return self.device.truth()["breakaway_torque_nm"]


def test_start_is_rest_then_peak_then_steady_rotation():
    bench = Bench(EXACT, QUIET, fixture_friction="0 N·m", inertia="0 kg·m²")
    angle, torque = bench.start(10.0)
    travel = np.degrees(angle - angle[0])
    assert (torque[:500] == 0).all()
    assert (travel[:500] == 0).all()
    assert torque.max() == pytest.approx(bench.truth_nm(), abs=2e-4)
    assert 0.05 < travel[torque.argmax()] < 0.5
    assert torque[-1] == pytest.approx(0.22, abs=1e-4)
    assert np.diff(angle)[-1] * 2000 == pytest.approx(2 * pi * 2 * RPM_HZ)


@pytest.mark.parametrize("rest_s", [10.0, 100.0, 1000.0])
def test_breakaway_torque_grows_with_logarithm_of_rest(rest_s):
    bench = Bench(EXACT, QUIET)
    list(bench.start(rest_s))
    expected = 0.30 + 0.015 * log10(rest_s + 0.25)
    assert bench.truth_nm() == pytest.approx(expected, rel=1e-12)


def test_rest_counts_from_last_motion():
    bench = Bench(EXACT, QUIET)
    for rest_s in (100.0, 5.0):
        list(bench.start(rest_s))
        assert bench.device.truth()["rest_s"] == pytest.approx(rest_s + 0.25)
    bench.device.set("frequency", 0.1)
    bench.clock.sleep(50.0)
    bench.device.set("frequency", 0.0)
    list(bench.start(7.0))
    assert bench.device.truth()["rest_s"] == pytest.approx(7.25)


def test_running_in_removes_excess_of_new_bearing():
    bench = Bench({"scatter": "0 %", "ageing": "0 N·m"}, QUIET)
    list(bench.start(1.0))
    assert bench.truth_nm() == pytest.approx(0.30 * 1.3)
    bench.device.set("frequency", 10 * RPM_HZ)
    bench.clock.sleep(18.0)
    bench.device.set("frequency", 0.0)
    list(bench.start(1.0))
    assert 3.0 < bench.device.truth()["turns"] < 3.2
    assert bench.truth_nm() == pytest.approx(0.30, rel=2e-3)


def test_starts_scatter_and_repeat_with_the_seed():
    truths = []
    for seed in (1, 1, 2):
        bench = Bench({"fresh_excess": "0 %"}, seed=seed)
        truths.append([bench.truth_nm() for _ in range(40) if list(bench.start(10.0))])
    assert truths[0] == truths[1] != truths[2]
    assert np.std(truths[0]) / np.mean(truths[0]) == pytest.approx(0.03, rel=0.35)


def test_start_needs_set_frequency_and_rest():
    bench = Bench(EXACT, QUIET)
    _, torque = bench.stream(0.5)
    assert (torque == 0).all()
    assert bench.device.truth() == {}
    bench.device.set("start_frequency", RPM_HZ)
    bench.device.set("frequency", 10 * RPM_HZ)
    angle, torque = bench.stream(0.5)
    assert torque == pytest.approx(0.224, abs=1e-4)
    assert np.diff(angle) == pytest.approx(2 * pi / 6 / 2000)
    assert bench.device.truth() == {}
    bench.device.make_safe()
    _, torque = bench.stream(0.5)
    assert (torque == 0).all()


def test_invalid_settings_and_unplugged_device_are_refused():
    with pytest.raises(PluginError, match="breakaway_torque must be above kinetic_torque"):
        Bench({"breakaway_torque": "0.1 N·m"})
    with pytest.raises(DeviceNotFoundError, match="no rotation_tester_sim answered"):
        Bench(simulate="unplugged")
