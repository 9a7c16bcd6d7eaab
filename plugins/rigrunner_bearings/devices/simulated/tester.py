"""The device around a simulated rig: drives, channels, streams, and the truth behind them."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from rigrunner.api import ChannelInfo, DriveInfo, Identity
from rigrunner_bearings.devices.simulated.connection import Connection
from rigrunner_bearings.devices.simulated.sampling import (
    RigState,
    noise_source,
    rig_source,
    sample_channels,
    true_frequency_hz,
)
from rigrunner_bearings.devices.simulated.sensor_errors import draw_constant_errors
from rigrunner_plugins.devices.channels import check_channels
from rigrunner_plugins.devices.drives import Drives
from rigrunner_plugins.devices.pacing import paced_blocks

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence

    from rigrunner.api import Array, Block, DeviceContext, StopToken
    from rigrunner_bearings.devices.simulated.sampling import SimulatedRig
    from rigrunner_bearings.devices.simulated.settings import TesterSettings
    from rigrunner_bearings.devices.simulated.specimen import Specimen

READINGS = 2**32
"""Repetitions from here on number single readings, so that they leave the streams' noise alone."""

LOAD_NOISE_N = 0.5
TEMPERATURE_K, TEMPERATURE_NOISE_K = 296.15, 0.02
HUMIDITY, HUMIDITY_NOISE = 0.45, 0.002
CHANNELS = (
    ChannelInfo("angle", "rad", "Swing angle"),
    ChannelInfo("torque", "N·m", "Torque in the shaft"),
    ChannelInfo("velocity", "rad/s", "Angular velocity of the swing"),
    ChannelInfo("index", "1", "One pulse in every turn of the crank"),
    ChannelInfo("load", "N", "Radial load"),
    ChannelInfo("temperature", "K", "Temperature of the bearing", shown_in="°C"),
    ChannelInfo("humidity", "1", "Relative humidity"),
)


class SimulatedTester:
    """A swing tester that exists only as a SimulatedRig; a Device with every ability.

    Constant errors follow from the seed; noise from seed, set-points and how often these were
    recorded, or read, so that neither the order of recordings matters nor that a run is resumed.
    """

    non_blocking = True

    def __init__(
        self,
        model: str,
        settings: TesterSettings,
        rig: SimulatedRig,
        context: DeviceContext,
        specimen: Specimen | None = None,
    ) -> None:
        """Make the device; a `specimen` wears and warms, and is a new one with each connection."""
        self._settings = settings
        self._rig = rig
        self._specimen = specimen
        self._clock = context.clock
        self._errors = draw_constant_errors(rig.sensors, rig_source(settings.seed))
        self._drives = Drives(_drives(settings), context.clock)
        self._connection = Connection(model, settings, context.clock)
        self._repetitions: Counter[tuple[float, float]] = Counter()
        self._readings: Counter[tuple[object, ...]] = Counter()
        self._truth: Mapping[str, float] = {}
        self._paused_hz: float | None = None

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        """The channels that can be read or streamed."""
        return CHANNELS

    @property
    def drives(self) -> Sequence[DriveInfo]:
        """Frequency and load."""
        return self._drives.infos

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        return self._rig.sensors.sample_rate_hz

    def connect(self, timeout_s: float) -> Identity:
        """Begin a set-up: its drift and its repetitions start again."""
        identity = self._connection.open(timeout_s)
        self._repetitions.clear()
        self._readings.clear()
        if self._specimen is not None:
            self._specimen.renew()
        return identity

    def close(self) -> None:
        """Release the connection; the rig stays as it is."""
        self._connection.close()

    def make_safe(self) -> Mapping[str, float]:
        """Stop the swing, then take the load away; a pause cannot be resumed."""
        self._paused_hz = None
        self._wear()
        return self._drives.make_safe()

    def pause(self) -> None:
        """Stop the swing under its load."""
        self._connection.need()
        self._paused_hz = self._drives.actual["frequency"]
        self.set("frequency", 0.0)

    def resume(self) -> None:
        """Swing again as before the pause."""
        self._connection.need()
        paused_hz, self._paused_hz = self._paused_hz, None
        if paused_hz is not None:
            self.set("frequency", paused_hz)

    def set(self, drive: str, value: float) -> None:
        """Move a drive at its rate; return when it is there."""
        self._connection.need()
        self._wear()
        self._drives.set(drive, value)

    def read_back(self, drive: str) -> float:
        """Return what the drive believes; a frequency error does not show here."""
        self._connection.need()
        return self._drives.read_back(drive)

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return one sample of each channel."""
        state = self._state()
        check_channels(channels, CHANNELS)
        setpoints = (state.frequency_hz, state.load_n)
        streams = self._repetitions[setpoints]
        # Each set of channels has its own count: interlocks read theirs at times of their own.
        since = (*setpoints, streams, tuple(channels))
        self._readings[since] += 1
        repetition = READINGS * (1 + streams) + self._readings[since]
        values = self._sample(state, 1, repetition, channels)
        return {name: float(values[name][0]) for name in channels}

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield blocks of at most 0.1 s at the pace of the clock."""
        state = self._state()
        check_channels(channels, CHANNELS)
        setpoints = (state.frequency_hz, state.load_n)
        samples = round(duration_s * self.sample_rate_hz)
        values = self._sample(state, samples, self._repetitions[setpoints], channels)
        self._repetitions[setpoints] += 1
        swinging_hz = true_frequency_hz(self._rig, state)
        steady = self._worn.steady_state(state.load_n, swinging_hz) if swinging_hz else None
        self._truth = {} if steady is None else steady.truth
        streamed = {name: values[name] for name in channels}
        return paced_blocks(streamed, self.sample_rate_hz, self._clock, stop)

    def continue_after(self, streams: Sequence[Mapping[str, float]]) -> None:
        """Give no later stream the noise of a stream that the run already has."""
        for setpoints in streams:
            self._repetitions[setpoints.get("frequency", 0.0), setpoints.get("load", 0.0)] += 1

    def truth(self) -> Mapping[str, float]:
        """Return what was true of the rig in the last stream; nothing if it was at rest."""
        return dict(self._truth)

    def _sample(
        self, state: RigState, samples: int, repetition: int, names: Collection[str]
    ) -> Mapping[str, Array]:
        """Return the samples of at least the named channels."""
        rng = noise_source(self._settings.seed, state, repetition)
        rise_k = 0.0 if self._specimen is None else self._specimen.rise_k
        channels = sample_channels(self._worn, state, samples, self._errors, rng, names=names)
        for name, mean, noise in (
            ("load", state.load_n, LOAD_NOISE_N),
            ("temperature", TEMPERATURE_K + rise_k, TEMPERATURE_NOISE_K),
            ("humidity", HUMIDITY, HUMIDITY_NOISE),
        ):
            if channels.keys() >= set(names):
                break  # only now: these three share one source of random numbers
            channels[name] = rng.normal(mean, noise, samples)
        return channels

    @property
    def _worn(self) -> SimulatedRig:
        return self._rig if self._specimen is None else self._specimen.rig

    def _wear(self) -> None:
        """Let the specimen wear and warm up to now."""
        if self._specimen is not None:
            actual = self._drives.actual
            self._specimen.wear(self._clock.monotonic_s(), actual["frequency"], actual["load"])

    def _state(self) -> RigState:
        elapsed_s = self._clock.monotonic_s() - self._connection.need()
        actual = self._drives.actual
        self._wear()
        return RigState(actual["frequency"], actual["load"], elapsed_s)


def _drives(settings: TesterSettings) -> tuple[DriveInfo, ...]:
    """Frequency first: a rig is made safe by stopping it before its load is taken away."""
    return (
        DriveInfo(
            name="frequency",
            unit="Hz",
            long_name="Swing frequency",
            minimum=0.0,
            maximum=settings.max_frequency,
            rate_per_s=settings.frequency_rate,
            sets_cycle_frequency=True,
        ),
        DriveInfo(
            name="load",
            unit="N",
            long_name="Radial load",
            minimum=0.0,
            maximum=settings.max_load,
            rate_per_s=settings.load_rate,
        ),
    )
