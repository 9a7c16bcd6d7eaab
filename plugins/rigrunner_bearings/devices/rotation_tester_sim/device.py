"""The bench as a device: a slow drive, an angle, a torque, and starts that are recorded whole.

Breakaway torque grows with the logarithm of the time at rest (Dieterich, Journal of Geophysical
Research 77 (1972) 3690). Over the first travel the friction rises exponentially, as in Dahl's
model of 1968, and then weakens to its kinetic value.
"""

from __future__ import annotations

from math import exp, log10
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import ChannelInfo, DriveInfo, Identity
from rigrunner_bearings.devices.simulated.connection import Connection
from rigrunner_bearings.devices.simulated.sensor_errors import (
    draw_constant_errors,
    read_angle,
    read_torque,
)
from rigrunner_plugins.devices.channels import check_channels
from rigrunner_plugins.devices.drives import Drives
from rigrunner_plugins.devices.pacing import paced_blocks

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api import Array, Block, DeviceContext, StopToken
    from rigrunner_bearings.devices.rotation_tester_sim.parameters import BenchParameters
    from rigrunner_bearings.devices.rotation_tester_sim.settings import RotationTesterSettings


SHORTEST_REST_S = 1.0
"""The law has no value at zero."""

SOLVER_POINTS = 20_000
FARTHEST = 20.0
"""Slip lengths within which the peak lies."""


def breakaway_torque_nm(bench: BenchParameters, rest_s: float, turns: float) -> float:
    """Return the expected breakaway torque after a rest, with so many turns since it was new."""
    fresh = bench.fresh_excess * exp(-turns / bench.running_in_turns)
    aged = bench.ageing_nm * log10(max(rest_s, SHORTEST_REST_S))
    return bench.breakaway_torque_nm * (1 + fresh) + aged


def friction_nm(bench: BenchParameters, travel_rad: Array, breakaway_nm: float) -> Array:
    """Return the friction over the travel since the start, shape (n,); its peak is the breakaway.

    It is a(d) + excess b(d) with b > 0, so it stays below the peak everywhere and touches it where
    the excess is the least of (peak - a)/b.
    """
    d = np.linspace(0, FARTHEST * bench.slip_rad, SOLVER_POINTS + 1)[1:]
    rising, weakening = _shape(bench, d)
    excess = ((breakaway_nm - bench.kinetic_torque_nm * rising) / (rising * weakening)).min()
    rising, weakening = _shape(bench, travel_rad)
    torque: Array = rising * (bench.kinetic_torque_nm + excess * weakening)
    return torque


def _shape(bench: BenchParameters, travel_rad: Array) -> tuple[Array, Array]:
    rising = -np.expm1(-travel_rad / bench.slip_rad)
    return rising, np.exp(-travel_rad / bench.weakening_rad)


REST_S = 0.25
"""A recorded start begins with so much rest."""


def start(time_s: Array, speed_rad_s: float, acceleration_rad_s2: float) -> tuple[Array, Array]:
    """Return travel in rad and acceleration in rad/s² at times of shape (n,)."""
    moving_s = np.maximum(time_s - REST_S, 0.0)
    until_s = speed_rad_s / acceleration_rad_s2
    gaining_s = np.minimum(moving_s, until_s)
    travel = acceleration_rad_s2 * gaining_s**2 / 2 + speed_rad_s * (moving_s - gaining_s)
    accelerating = (time_s >= REST_S) & (moving_s < until_s)
    return travel, np.where(accelerating, acceleration_rad_s2, 0.0)


class History:
    """Turns since the bearing was new, and when it last moved, by the times passed in."""

    def __init__(self, now_s: float) -> None:
        self._turns = 0.0
        self._since_s = now_s
        self._frequency_hz = 0.0

    def turns(self, now_s: float) -> float:
        """Return the turns made until now."""
        return self._turns + self._frequency_hz * (now_s - self._since_s)

    def rest_s(self, now_s: float) -> float:
        """Return how long the bearing has been at rest; 0 while it turns."""
        return 0.0 if self._frequency_hz else now_s - self._since_s

    def change(self, now_s: float, frequency_hz: float) -> None:
        """From now on the bearing turns so fast; 0: it rests."""
        if frequency_hz == self._frequency_hz:
            return
        self._turns = self.turns(now_s)
        self._since_s, self._frequency_hz = now_s, frequency_hz

    def add_start(self, until_s: float, turns: float) -> None:
        """Add a start that was over at that time."""
        self._turns += turns
        self._since_s = until_s


MODEL = "rotation_tester_sim"
TURN_RAD = 2 * np.pi
LOAD_RATE_N_S = 100.0
CHANNELS = (
    ChannelInfo("angle", "rad", "Angle of rotation"),
    ChannelInfo("torque", "N·m", "Torque in the shaft"),
)


class RotationTester:
    """A bench on which a bearing turns, under a load where the bench has one.

    With `start_frequency` set and the drive at rest, every stream is a start: a short rest, then
    rotation until the stream ends. At rest the drive lets go, and the shaft carries no torque.
    """

    non_blocking = True

    def __init__(self, settings: RotationTesterSettings, context: DeviceContext) -> None:
        self._settings = settings
        self._bench = settings.parameters()
        self._clock = context.clock
        self._errors = draw_constant_errors(
            self._bench.sensors, np.random.default_rng([settings.seed, 0])
        )
        self._drives = Drives(_drives(settings), context.clock)
        self._connection = Connection(MODEL, settings, context.clock)
        self._history = History(context.clock.monotonic_s())
        self._streams = 0
        self._truth: Mapping[str, float] = {}

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        """Angle and torque."""
        return CHANNELS

    @property
    def drives(self) -> Sequence[DriveInfo]:
        """The rotation, and that with which recorded starts begin."""
        return self._drives.infos

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        return self._bench.sensors.sample_rate_hz

    def connect(self, timeout_s: float) -> Identity:
        """Begin a set-up with a new bearing."""
        identity = self._connection.open(timeout_s)
        self._history = History(self._connection.need())
        self._streams = 0
        return identity

    def close(self) -> None:
        """Release the connection."""
        self._connection.close()

    def make_safe(self) -> Mapping[str, float]:
        """Stop the rotation; later streams are no starts."""
        actual = self._drives.make_safe()
        self._update_history()
        return actual

    def set(self, drive: str, value: float) -> None:
        """Move a drive at its rate; return when it is there."""
        self._connection.need()
        self._drives.set(drive, value)
        self._update_history()

    def read_back(self, drive: str) -> float:
        """Return the present value of a drive."""
        self._connection.need()
        return self._drives.read_back(drive)

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return one sample of each channel; a single reading starts nothing."""
        self._connection.need()
        check_channels(channels, CHANNELS)
        values = self._sample(np.zeros(1), starts=False)
        return {name: float(values[name][0]) for name in channels}

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield blocks of at most 0.1 s at the pace of the clock."""
        self._connection.need()
        check_channels(channels, CHANNELS)
        time_s = np.arange(round(duration_s * self.sample_rate_hz)) / self.sample_rate_hz
        actual = self._drives.actual
        self._truth = {}
        starts = actual["start_frequency"] > 0 and actual["frequency"] == 0
        values = self._sample(time_s, starts=starts)
        streamed = {name: values[name] for name in channels}
        return paced_blocks(streamed, self.sample_rate_hz, self._clock, stop)

    def continue_after(self, streams: Sequence[Mapping[str, float]]) -> None:
        """Give no later stream the noise of a stream that the run already has."""
        self._streams += len(streams)

    def truth(self) -> Mapping[str, float]:
        """Return what was true of the start in the last stream; nothing if it was none."""
        return dict(self._truth)

    def _sample(self, time_s: Array, *, starts: bool) -> Mapping[str, Array]:
        rng = np.random.default_rng([self._settings.seed, 1, self._streams])
        self._streams += 1
        now_s = self._clock.monotonic_s()
        angle, torque = (
            self._starting(time_s, now_s, rng) if starts else self._rotating(time_s, now_s)
        )
        elapsed_s = now_s - self._connection.need() + time_s
        sensors = self._bench.sensors
        return {
            "torque": read_torque(torque, elapsed_s, sensors, self._errors, rng),
            "angle": read_angle(angle, sensors, rng),
        }

    def _rotating(self, time_s: Array, now_s: float) -> tuple[Array, Array]:
        """Return angle and torque of even rotation, or of rest."""
        frequency_hz = self._drives.actual["frequency"]
        angle = TURN_RAD * (self._history.turns(now_s) + frequency_hz * time_s)
        bench = self._bench_under_load()
        torque = (bench.kinetic_torque_nm + bench.fixture_friction_nm) * (frequency_hz > 0)
        return angle, np.full(len(time_s), torque)

    def _starting(
        self, time_s: Array, now_s: float, rng: np.random.Generator
    ) -> tuple[Array, Array]:
        """Return angle and torque of a start, and add it to the history."""
        bench, history = self._bench_under_load(), self._history
        speed = TURN_RAD * self._drives.actual["start_frequency"]
        travel, acceleration = start(time_s, speed, bench.acceleration_rad_s2)
        turns, rest_s = history.turns(now_s), history.rest_s(now_s) + REST_S
        expected = breakaway_torque_nm(bench, rest_s, turns)
        breakaway = expected * (1 + bench.scatter * float(rng.standard_normal()))
        self._truth = {"breakaway_torque_nm": breakaway, "rest_s": rest_s, "turns": turns}
        moving = bench.fixture_friction_nm * (travel > 0)
        torque = friction_nm(bench, travel, breakaway) + moving + bench.inertia_kgm2 * acceleration
        duration_s = len(time_s) / self.sample_rate_hz
        history.add_start(now_s + duration_s, float(travel[-1]) / TURN_RAD)
        return TURN_RAD * turns + travel, torque

    def _bench_under_load(self) -> BenchParameters:
        """Return the bench under the load that is set."""
        return self._bench.under_load(self._drives.actual.get("load", 0.0))

    def _update_history(self) -> None:
        """Pass on how fast the bearing turns now."""
        self._history.change(self._clock.monotonic_s(), self._drives.actual["frequency"])


def _drives(settings: RotationTesterSettings) -> tuple[DriveInfo, ...]:
    load = DriveInfo("load", "N", "Load", 0.0, settings.max_load, rate_per_s=LOAD_RATE_N_S)
    return (
        *((load,) if settings.max_load > 0 else ()),
        DriveInfo(
            name="frequency",
            unit="Hz",
            long_name="Rotation",
            minimum=0.0,
            maximum=settings.max_frequency,
            rate_per_s=settings.frequency_rate,
            sets_cycle_frequency=True,
        ),
        DriveInfo(
            name="start_frequency",
            unit="Hz",
            long_name="Rotation with which recorded starts begin",
            minimum=0.0,
            maximum=settings.max_start_frequency,
        ),
    )
