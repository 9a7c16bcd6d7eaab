"""Two clocks on one time base: the stated alignment is true.

Each instrument samples known signals of the true time by its own clock; the time between the
channels of the recording is computed from these signals, not taken from the composite.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from rigrunner.api.data import Block
from rigrunner.api.devices import ChannelInfo, DeviceContext, Identity, Patience
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner.clock import SimulatedClock, WallClock
from rigrunner_plugins.devices.composite.clocks.common_signal import coarse_lag, fine_lag
from rigrunner_plugins.devices.composite.clocks.relation import Sighting, by_arrivals, line_through
from rigrunner_plugins.devices.composite.device import make
from rigrunner_plugins.devices.composite.settings import CompositeSettings

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence


BLOCK_S = 0.1


@dataclass
class Sampler:
    """Samples signals of the true time by its own clock, and delivers blocks late."""

    clock: SimulatedClock
    signals: Mapping[str, Callable[[np.ndarray], np.ndarray]]
    """Channel to its value at true times (n,)."""
    sample_rate_hz: float = 10_000.0
    clock_error: float = 0.0
    """Relative: above 0 if the clock is fast."""
    start_s: float = 0.0
    """The delay from the call of `stream` to the first sample."""
    latency_s: float = 0.0
    """The minimum delay of a block."""
    jitter_s: float = 0.0
    """The mean of the additional delay, exponentially distributed."""
    seed: int = 0
    lost: int | None = None
    """The block that never arrives."""
    drives: Sequence[object] = ()
    non_blocking: bool = True
    is_open: bool = field(default=False, init=False)
    streams: int = field(default=0, init=False)

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        return [ChannelInfo(name, "N·m", name) for name in self.signals]

    def connect(self, timeout_s: float) -> Identity:  # noqa: ARG002
        return Identity("Clocks", "sampler", str(self.seed))

    def make_safe(self) -> Mapping[str, float]:
        return {}

    def close(self) -> None:
        pass

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        now = np.array([self.clock.monotonic_s()])
        return {name: float(self.signals[name](now)[0]) for name in channels}

    def stream(self, channels: Sequence[str], duration_s: float, stop) -> Iterator[Block]:
        self.streams += 1
        rng = np.random.default_rng([self.seed, self.streams])
        rate = self.sample_rate_hz * (1 + self.clock_error)
        start_s = self.clock.monotonic_s() + self.start_s
        size = round(BLOCK_S * self.sample_rate_hz)
        self.is_open = True
        try:
            for index, first in enumerate(range(0, round(duration_s * self.sample_rate_hz), size)):
                if stop.is_set() or index == self.lost:
                    return
                true_s = start_s + (first + np.arange(size)) / rate
                late_s = self.latency_s + rng.exponential(self.jitter_s or 1e-12)
                due_s = start_s + (first + size) / rate + late_s
                self.clock.sleep(max(due_s - self.clock.monotonic_s(), 0.0))
                values = {name: self.signals[name](true_s) for name in channels}
                block_start_s = due_s - size / self.sample_rate_hz
                yield Block(self.sample_rate_hz, first, block_start_s, values)
        finally:
            self.is_open = False


CHANNELS = {"torque": "daq.torque", "angle": "enc.angle"}
COMMON = {"common": {"daq": "sync", "enc": "sync"}}


def swing(hz):
    return lambda t: np.sin(2 * np.pi * hz * t) + 0.3 * np.sin(6 * np.pi * hz * t + 1)


class Bench:
    """A torque bridge and an encoder of two clocks."""

    answer_s = 5.0
    """How long a block is waited for."""

    def __init__(self, hz=35.0, noise=0.002, seed=1, clocks=COMMON, clock=None, **of_encoder):
        self.clock = clock or SimulatedClock()
        rng = np.random.default_rng(seed)

        def noisy(t):
            return swing(hz)(t) + noise * rng.standard_normal(len(t))

        daq = {"torque": swing(hz), "sync": noisy}
        self.daq = Sampler(self.clock, daq, latency_s=0.001, jitter_s=0.0005, seed=seed)
        settings = {"start_s": 0.037, "latency_s": 0.003, "jitter_s": 0.002, "clock_error": 5e-5}
        enc = {"angle": swing(hz), "sync": noisy}
        self.enc = Sampler(self.clock, enc, seed=seed + 1, **{**settings, **of_encoder})
        self.settings = {
            "parts": {"daq": {"plugin": "daq"}, "enc": {"plugin": "enc"}},
            "channels": CHANNELS,
            "clocks": clocks,
        }

    def device(self):
        parts = {"daq": self.daq, "enc": self.enc}
        context = DeviceContext(
            "tester",
            self.clock,
            Path(),
            make=lambda plugin, _settings, /, part="": parts[part or plugin],
            patience=Patience(answer_s=self.answer_s),
        )
        device = make(CompositeSettings.model_validate(self.settings), context)
        device.connect(1.0)
        return device

    def record(self, seconds=0.9):
        """Return channels, by how much the angle is late in s, and the stated conditions."""
        device = self.device()
        blocks = list(device.stream(["angle", "torque"], seconds, threading.Event()))
        firsts = [block.first_sample for block in blocks]
        assert firsts == list(np.cumsum([0, *(block.samples for block in blocks)])[:-1])
        channels = {
            name: np.concatenate([block.channels[name] for block in blocks])
            for name in ("angle", "torque")
        }
        conditions = {name: value for name, (value, _) in device.stream_conditions().items()}
        return channels, late_s(channels), conditions


def late_s(channels):
    """Return the mean time by which the angle lags behind the torque, the same signal."""
    slope = np.gradient(channels["torque"]) * 10_000
    return float((channels["torque"] - channels["angle"]) @ slope / (slope @ slope))


@pytest.mark.parametrize("hz", [8.0, 35.0])
def test_common_signal_aligns_to_microseconds_with_a_true_u(hz):
    errors_in_u = []
    for seed in range(12):
        _, late, conditions = Bench(hz, seed=seed).record()
        assert conditions["angle_alignment_u"] < 10e-6
        errors_in_u.append(late / conditions["angle_alignment_u"])
    assert np.mean(np.abs(errors_in_u) < 2) >= 0.9
    assert max(map(abs, errors_in_u)) < 3


def test_rate_of_the_other_clock_is_estimated():
    _, _, conditions = Bench().record(3.0)
    assert conditions["angle_clock_rate"] == pytest.approx(5e-5, abs=2e-6)


def test_without_a_common_signal_arrival_times_align_to_the_latency():
    errors_in_u = []
    for seed in range(12):
        _, late, conditions = Bench(hz=3.0, seed=seed, clocks={}).record()
        assert 4e-3 < conditions["angle_alignment_u"] < 6e-3  # 10 ms / sqrt(6) = 4.1 ms, and jitter
        errors_in_u.append(late / conditions["angle_alignment_u"])
    assert max(map(abs, errors_in_u)) < 2
    closer = Bench(hz=3.0, clocks={"latency": "1 ms"}, latency_s=0.001)
    assert closer.record()[2]["angle_alignment_u"] < 1.5e-3


def test_common_signal_that_differs_or_is_constant_is_not_used():
    for seed in range(3):
        bench = Bench(seed=seed)
        rng = np.random.default_rng(seed)
        bench.enc.signals = {**bench.enc.signals, "sync": lambda t: rng.standard_normal(len(t))}  # noqa: B023
        assert bench.record()[2]["angle_alignment_u"] > 4e-3
    still = Bench()
    still.daq.signals = {**still.daq.signals, "sync": np.zeros_like}
    assert still.record()[2]["angle_alignment_u"] > 4e-3


@pytest.mark.parametrize("rate_hz", [2000.0, 9999.0])
def test_other_nominal_rate_is_resampled_to_that_of_the_reference(rate_hz):
    channels, late, conditions = Bench(sample_rate_hz=rate_hz).record()
    assert len(channels["angle"]) == len(channels["torque"]) == 9000
    assert abs(late) < 4 * conditions["angle_alignment_u"] < 30e-6
    assert np.abs(channels["angle"] - channels["torque"]).max() < 5e-3


def test_reference_that_is_not_the_fastest_is_refused():
    bench = Bench(sample_rate_hz=20_000.0)
    with pytest.raises(PluginError, match=r"reference must be the fastest: 'reference: enc'"):
        bench.device()
    bench.settings["clocks"] = {**COMMON, "reference": "enc"}
    assert bench.device().sample_rate_hz == 20_000.0


@pytest.mark.parametrize(
    ("clocks", "message"),
    [
        ({"reference": "press"}, "there is no part 'press'"),
        ({"common": {"daq": "sync", "press": "sync"}}, "there is no part 'press'"),
        ({"common": {"daq": "synk", "enc": "sync"}}, "has no channel 'synk'"),
    ],
)
def test_clocks_that_do_not_fit_the_parts_are_refused(clocks, message):
    with pytest.raises((PluginError, ValueError), match=message):
        Bench(clocks=clocks).device()


def test_channels_of_one_clock_have_no_stream_conditions():
    device = Bench().device()
    assert list(device.stream(["torque"], 0.3, threading.Event()))
    assert device.stream_conditions() == {}


@pytest.mark.parametrize("clocks", [COMMON, {}])
def test_channel_of_the_slower_part_has_the_rate_of_the_reference(clocks):
    device = Bench(sample_rate_hz=2000.0, clocks=clocks).device()
    blocks = list(device.stream(["angle"], 0.3, threading.Event()))
    assert {block.rate_hz for block in blocks} == {10_000.0}


def test_stop_ends_both_streams():
    bench = Bench()
    stop = threading.Event()
    for count, _ in enumerate(bench.device().stream(["angle", "torque"], 5.0, stop)):
        if count == 2:
            stop.set()
    assert count < 5
    assert not bench.daq.is_open
    assert not bench.enc.is_open


def test_closing_the_stream_ends_both():
    bench = Bench()
    blocks = bench.device().stream(["angle", "torque"], 5.0, threading.Event())
    next(blocks)
    blocks.close()
    assert not bench.daq.is_open
    assert not bench.enc.is_open


def test_part_whose_stream_ends_early_is_named():
    bench = Bench(lost=14)
    with pytest.raises(DeviceLostError, match="the stream of enc ended before its time"):
        bench.record()
    assert not bench.daq.is_open


def test_part_with_a_gap_or_a_wrong_rate_is_named():
    bench = Bench()
    plain = bench.enc.stream

    def skipping(*arguments):
        for index, block in enumerate(plain(*arguments)):
            if index != 5:
                yield block

    bench.enc.stream = skipping
    with pytest.raises(DeviceLostError, match="enc: sample 6000 came, 5000 was due"):
        bench.record()
    bench.enc.stream = lambda *arguments: (replace(b, rate_hz=9000.0) for b in plain(*arguments))
    with pytest.raises(DeviceRejectedError, match="enc: the stream has 9000 samples per second"):
        bench.record()


@pytest.mark.parametrize("part", ["daq", "enc"])
def test_part_with_complex_samples_is_named(part):
    """Samples of two clocks are resampled, and an imaginary part would be lost."""
    bench = Bench()
    sampler = getattr(bench, part)
    plain = sampler.stream

    def imaginary(*arguments):
        for block in plain(*arguments):
            spoilt = {name: values + 0.5j for name, values in block.channels.items()}
            yield replace(block, channels=spoilt)

    sampler.stream = imaginary
    with pytest.raises(DeviceRejectedError, match="the samples are complex128, expected real"):
        bench.record()


def test_threads_and_the_wall_clock_give_the_true_offset():
    bench = Bench(hz=3.0, clocks={"lead": "0.5 s"}, clock=WallClock(), non_blocking=False)
    bench.daq.non_blocking = False
    _, late, conditions = bench.record(0.4)
    # A busy machine delivers blocks late, which increases the stated u; 8 ms on an idle one.
    assert abs(late) < 2 * conditions["angle_alignment_u"]


def test_hanging_part_is_reported_in_time_and_can_be_closed():
    release = threading.Event()
    bench = Bench(clock=WallClock(), non_blocking=False)
    bench.daq.non_blocking = False
    bench.answer_s = 2.0
    plain = bench.enc.stream

    def hanging(*arguments):
        for index, block in enumerate(plain(*arguments)):
            if index == 3:
                release.wait(60)
            yield block

    bench.enc.stream = hanging
    device = bench.device()
    with pytest.raises(DeviceTimeoutError, match="enc: no block came within 2 s"):
        list(device.stream(["angle", "torque"], 30.0, threading.Event()))
    release.set()
    device.close()


def test_line_through_sightings_is_weighted():
    tau = np.array([0.0, 1.0, 2.0, 3.0])
    sightings = [Sighting(tau_s, 0.1 + 2e-5 * tau_s, 1e-7) for tau_s in tau]
    relation = line_through(sightings)
    assert relation.rate == pytest.approx(2e-5, rel=1e-3)
    assert relation.delta_s(np.array([5.0]))[0] == pytest.approx(0.1001, abs=1e-8)
    assert relation.u_offset_s == pytest.approx(1e-7 / 2)  # four sightings
    assert relation.u_rate == pytest.approx(1e-7 / np.sqrt(5), rel=1e-3)  # sum (tau - 1.5)^2 = 5


def test_one_sighting_has_the_rate_uncertainty_of_a_quartz():
    relation = line_through([Sighting(1.0, 0.1, 1e-6)])
    assert (relation.rate, relation.u_rate) == (0.0, 1e-4)
    assert relation.u_s(np.array([11.0])) == pytest.approx(1e-3, rel=1e-3)


def test_arrival_times_give_offset_and_rate_of_long_streams():
    rng = np.random.default_rng(3)
    ends = np.arange(1, 6001) / 10.0  # ten minutes of blocks
    arrivals_s = ends + 5.0 + rng.exponential(1e-3, len(ends))
    other_arrivals_s = ends * (1 - 3e-5) + 5.02 + rng.exponential(1e-3, len(ends))
    relation = by_arrivals((ends, arrivals_s), (ends, other_arrivals_s), 0.0)
    assert relation.rate == pytest.approx(3e-5, abs=4e-6)
    middle = np.array([300.0])
    expected = 3e-5 * 300 - 0.02
    assert relation.delta_s(middle)[0] == pytest.approx(expected, abs=4 * relation.u_s(middle))
    assert relation.u_s(middle) < 1e-3


def test_lag_of_noisy_signals_is_within_its_uncertainty():
    rng = np.random.default_rng(5)
    errors_in_u = []
    for _ in range(100):
        x = np.arange(2500.0)
        window = np.sin(x / 40) + 0.05 * rng.standard_normal(2500)
        other = 2 * np.sin((np.arange(2600.0) - 50.3) / 40) + 1 + 0.1 * rng.standard_normal(2600)
        start = coarse_lag(window, other, 1.0)
        lag = fine_lag(window, other, 1.0, start)
        errors_in_u.append((lag.samples - 50.3) / lag.u_samples)
    assert np.std(errors_in_u) == pytest.approx(1.0, abs=0.25)
    assert abs(np.mean(errors_in_u)) < 0.3


def test_signal_that_repeats_within_the_search_is_no_sighting():
    window = np.sin(2 * np.pi * np.arange(500) / 50)
    other = np.sin(2 * np.pi * np.arange(700) / 50)
    assert coarse_lag(window, other, 1.0) is None
