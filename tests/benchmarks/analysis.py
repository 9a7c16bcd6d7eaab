"""The kernels of the analysis: cycles and their extremes, compared with `np.max`.

Rates are samples of one channel per second. The floor is `np.max` over one channel of the same
recording: 6 M samples at 100 kS/s, a swing of the tester with 0.2 % noise (2 % at 1 Hz in a
separate row). Ours reads two channels: it finds the cycles in the angle by hysteresis and takes the
minimum and the maximum of the torque in each. Both are timed in turn, in processor time.

There is no accelerator: one pass over both channels compiled by numba reached 0.14 of the floor
where this reached 0.28, since hysteresis proceeds sample by sample, and `np.max` eight at a time.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.frame import Figure, Work, allocated_peak, at_least, calls, pair_of
from rigrunner.signal.crossings import beyond, rises
from rigrunner.signal.extremes import extremes
from rigrunner_bearings.signal.cycles import HYSTERESIS, find_cycles, resample
from rigrunner_bearings.signal.kinematics import angular_velocity, swing_angle

if TYPE_CHECKING:
    from collections.abc import Callable

    from benchmarks.frame import Pair, Scale, Target
    from rigrunner.api.data import Array

RATE_HZ = 100e3
RATIO = 2 / 45
SAMPLES = 6_000_000
MANY = (
    "many short cycles: numpy takes 0.2 us more for each, and near a crossing samples go one by one"
)


def recording(samples: int, frequency_hz: float, noise: float) -> tuple[Array, Array]:
    """Return angle in rad and torque in N·m: friction with the sign of the swing, and inertia."""
    rng = np.random.default_rng(1)
    phase = 2 * np.pi * frequency_hz / RATE_HZ * np.arange(samples) + 0.3
    angle = swing_angle(phase, RATIO) + noise * RATIO * rng.standard_normal(samples)
    torque = 0.5 * np.tanh(20 * angular_velocity(phase, 1 / (2 * np.pi), RATIO) / RATIO)
    return angle, torque - 0.2 * np.sin(phase) + 0.01 * rng.standard_normal(samples)


def cycles(angle: Array) -> Array:
    before, after = rises(angle, *beyond(0.0, HYSTERESIS * RATIO))
    return np.asarray((before + after) / 2)


def with_extremes(angle: Array, torque: Array) -> tuple[Array, Array]:
    return extremes(torque, np.ceil(cycles(angle)).astype(np.intp))


def simple_extremes(angle: Array, torque: Array) -> tuple[Array, Array]:
    """Return the extremes by simple numpy: masks, their indices, reduceat."""
    limit = HYSTERESIS * RATIO
    outside = np.flatnonzero(np.abs(angle) > limit)
    rising = np.flatnonzero(np.diff(np.sign(angle[outside])) > 0)
    starts = (outside[rising] + outside[rising + 1] + 1) // 2
    complete = torque[: starts[-1]]
    return np.minimum.reduceat(complete, starts[:-1]), np.maximum.reduceat(complete, starts[:-1])


def certified(angle: Array, torque: Array) -> Array:
    """Resample as `analyse` does: with refined starts, and a spline for every cycle."""
    return resample(torque, find_cycles(angle, RATE_HZ, RATIO).starts)


@dataclass(frozen=True)
class Row:
    """One kernel on one recording."""

    what: str
    kernel: Callable[[Array, Array], object]
    target: Target | None = None
    limit: str = ""
    role: str = "ours"

    def figure(self, channels: tuple[Array, Array], where: str, times: int) -> Figure:
        pair = turns(partial(self.kernel, *channels), partial(np.max, channels[0]), times)
        rate = pair.ours.rate(len(channels[0]) / 1e6)
        what = f"{self.what}, {where}"
        return Figure(what, rate, "MS/s", self.role, pair.speed, self.target, self.limit)


EXTREMES = Row("cycles and extremes", with_extremes)
SIMPLE = Row("the extremes by straight numpy", simple_extremes, role="floor")
CERTIFIED = Row(
    "cycles as a certificate has them",
    certified,
    limit="least squares of the kinematics, and splines of degree 5: a phase good to 1e-5",
)


def turns(ours: Callable[[], object], floor: Callable[[], object], times: int) -> Pair:
    """Pair the processor times of both."""
    ours(), floor()
    return pair_of((processor_s(ours), processor_s(floor)) for _ in range(times))


def processor_s(call: Callable[[], object]) -> float:
    began_s = time.thread_time()
    call()
    return time.thread_time() - began_s


def measure(scale: Scale) -> list[Figure]:
    samples, times = scale.of(SAMPLES, 600_000), scale.of(15, 3)
    figures = []
    for frequency_hz, noise in ((1, 0.002), (1, 0.02), (10, 0.002), (35, 0.002)):
        where = f"{frequency_hz} Hz, noise {noise:.1%}"
        channels = recording(samples, frequency_hz, noise)
        has_target = frequency_hz == 1
        limit = "" if has_target else MANY
        row = replace(EXTREMES, target=at_least(0.25) if has_target else None, limit=limit)
        figures.append(row.figure(channels, where, times))
    angle, torque = recording(samples, 1, 0.002)
    quarter = recording(samples // 4, 10, 0.002)
    figures.append(CERTIFIED.figure(quarter, "10 Hz, noise 0.2%", scale.of(3, 1)))
    figures.append(SIMPLE.figure((angle, torque), "1 Hz, noise 0.2%", scale.of(5, 1)))
    floor = turns(partial(np.max, angle), partial(np.max, torque), times).ours
    rate = floor.rate(samples / 1e6)
    return [*figures, Figure("np.max over one channel", rate, "MS/s", "floor")]


def work() -> list[Work]:
    samples = 1_000_000
    channels = recording(samples, 10, 0.002)
    kernel = partial(with_extremes, *channels)
    kernel()
    return [
        Work("bytes for a sample, at most at once", allocated_peak(kernel) / samples, 4.0),
        Work("calls for a million samples", calls(kernel), 600),
    ]
