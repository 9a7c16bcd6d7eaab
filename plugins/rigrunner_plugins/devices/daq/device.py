"""A data acquisition device: all channels on one sample clock, read in blocks of a tenth second."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import (
    Block,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    Driver,
    Identity,
)
from rigrunner_plugins.devices.daq.daqmx import Acquisition, Outputs, facts
from rigrunner_plugins.devices.daq.settings import (
    DigitalOutput,
)
from rigrunner_plugins.devices.declared import drive_infos

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api import Array, DeviceContext, StopToken
    from rigrunner_plugins.devices.daq.settings import DaqSettings

BLOCK_S = 0.1
"""A stop is looked at between blocks."""
ANSWER_S = 5.0
"""How long a block may be late beyond its own duration."""
RATE_AGREES = 1e-6
"""Relative: how far the device's rate may be from the one that the station states."""


class Daq(Driver):
    """A device that Streams; its values come from the same samples as its recordings."""

    reads_back_while_streaming = True

    def __init__(self, settings: DaqSettings, context: DeviceContext) -> None:
        infos = [channel.info(name) for name, channel in settings.channels.items()]
        super().__init__(context, infos, drive_infos(settings.drives))
        self._settings = settings
        self._outputs: Outputs | None = None
        self._written: dict[str, float] = {}
        self._filters: Mapping[str, tuple[float, str]] = {}
        self._newest: Mapping[str, float] | None = None

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        return self._settings.rate

    def open(self, timeout_s: float) -> Identity:  # noqa: ARG002  (the driver has its own)
        """Find the device, try its channels once, and refuse another one or another rate."""
        self.shut()
        info = facts(self._settings.device)
        expected = self._settings.expect
        parts = {"model": (expected.model, info.model), "serial": (expected.serial, info.serial)}
        for key, (stated, actual) in parts.items():
            if stated is not None and stated.strip().upper() != actual.upper():
                raise DeviceNotFoundError(
                    f"{self._settings.device} has the {key} '{actual}', expected '{stated}'",
                    hint="see info and expect in the station, and the names in NI MAX",
                )
        acquisition = Acquisition(self._settings)
        try:
            actual_hz, stated_hz = acquisition.rate_hz, self.sample_rate_hz
            if abs(actual_hz / stated_hz - 1) > RATE_AGREES:
                raise DeviceRejectedError(
                    f"{self._settings.device} cannot sample at {stated_hz:g} Hz:"
                    f" the nearest rate is {actual_hz:.6f} Hz",
                    hint=f"write 'rate: {actual_hz!r} Hz' in the station",
                )
            self._filters = acquisition.filters()
        finally:
            acquisition.close()
        self._outputs = Outputs(self._settings.drives)
        firmware = f"NI-DAQmx {info.driver}"
        return Identity(
            "National Instruments", info.model, info.serial, firmware, simulated=info.simulated
        )

    def shut(self) -> None:
        """Give the outputs' tasks back; recordings have ended by themselves."""
        self._written.clear()
        outputs, self._outputs = self._outputs, None
        if outputs is not None:
            outputs.close()

    def get(self, channel: str) -> float:
        """Return the mean over a tenth second; while a recording runs, of its newest block."""
        return self.read([channel])[channel]

    def read(self, channels: Sequence[str]) -> dict[str, float]:
        """Return the same of several channels, of the same samples."""
        self.check_channels(channels)
        values = self._glance() if self._newest is None else self._newest
        return {name: values[name] for name in channels}

    def put(self, drive: str, value: float) -> None:
        """Give out what belongs to a set-point."""
        output = self._settings.drives[drive]
        number = output.from_si(value)
        if isinstance(output, DigitalOutput) and round(number, 6) not in (0.0, 1.0):
            raise DeviceRejectedError(
                f"{drive} is a line and cannot be set to {value:g}",
                hint=f"allowed: {output.to_si(0.0):g} or {output.to_si(1.0):g}",
            )
        self._opened().write(drive, number)
        self._written[drive] = value

    def actual(self, drive: str) -> float:
        """Return the value of its read-back channel, the level of its line, or its set-point.

        Raises DeviceRejectedError where nothing says it and nothing was written yet.
        """
        output = self._settings.drives[drive]
        if isinstance(output, DigitalOutput):
            return output.to_si(self._opened().read_line(drive))
        if output.read_back is not None:
            return self.get(output.read_back)
        if drive not in self._written:
            raise DeviceRejectedError(
                f"{drive} was not set since the connection was opened, and nothing measures it",
                hint="name a channel as its read_back",
            )
        return self._written[drive]

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield blocks of at most 0.1 s; raise DeviceLostError where samples were overwritten."""
        self.check_channels(channels)
        return self._blocks(channels, duration_s, stop)

    def stream_conditions(self) -> Mapping[str, tuple[float, str]]:
        """Return delay and corner of each channel's filter, as far as the device reports them."""
        return self._filters

    def _blocks(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        total, size = round(duration_s * self.sample_rate_hz), self._block_samples
        acquisition = Acquisition(self._settings)
        try:
            acquisition.start()
            for first in range(0, total, size):
                if stop.is_set():
                    return
                values = self._next(acquisition, min(size, total - first))
                arrived_s = self.clock.monotonic_s()
                part = {name: values[name] for name in channels}
                yield Block(self.sample_rate_hz, first, arrived_s, part)
        finally:
            self._newest = None
            acquisition.close()

    def _next(self, acquisition: Acquisition, samples: int) -> Mapping[str, Array]:
        raw = acquisition.read(samples, BLOCK_S + ANSWER_S)
        settings = self._settings.channels
        values = {name: settings[name].to_si(numbers) for name, numbers in raw.items()}
        self._newest = {name: float(np.mean(samples)) for name, samples in values.items()}
        return values

    def _glance(self) -> Mapping[str, float]:
        acquisition = Acquisition(self._settings)
        try:
            acquisition.start()
            self._next(acquisition, self._block_samples)
            assert self._newest is not None  # noqa: S101  (a block has come)
            return self._newest
        finally:
            self._newest = None
            acquisition.close()

    @property
    def _block_samples(self) -> int:
        return max(1, round(BLOCK_S * self.sample_rate_hz))

    def _opened(self) -> Outputs:
        if self._outputs is None:
            raise DeviceLostError("not connected")
        return self._outputs
