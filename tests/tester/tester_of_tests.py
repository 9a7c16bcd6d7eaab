"""The tests' own tester, installed as a third-party package; its torque is known.

At rest it shows its offset, `OFFSET_NM`. When turning, the mean over whole cycles also has
`IDLE_NM` and `PER_NEWTON_NM` for each newton of load; a sine is added, and new noise
for each recording of the same set-points.
"""

from __future__ import annotations

from collections import Counter
from typing import Literal

import numpy as np

from rigrunner.api import (
    AnyQuantity,
    ChannelInfo,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRecord,
    DriveInfo,
    Identity,
    Settings,
    hookimpl,
)
from rigrunner_plugins.devices.channels import check_channels
from rigrunner_plugins.devices.drives import Drives
from rigrunner_plugins.devices.pacing import paced_blocks

api_version = 1

OFFSET_NM, IDLE_NM, PER_NEWTON_NM, SINE_NM = 0.01, 0.3, 0.0007, 0.1
SWING_RAD, TEMPERATURE_K = 0.05, 296.65
NOISE = {"angle": 0.0, "torque": 1e-3, "load": 0.02, "temperature": 0.02}
CHANNELS = (
    ChannelInfo("angle", "rad", "Angle"),
    ChannelInfo("torque", "N·m", "Torque"),
    ChannelInfo("load", "N", "Load"),
    ChannelInfo("temperature", "K", "Temperature", shown_in="°C"),
)
DRIVES = (
    DriveInfo(
        "frequency", "Hz", "Frequency", 0.0, 35.0, rate_per_s=20.0, sets_cycle_frequency=True
    ),
    DriveInfo("load", "N", "Load", 0.0, 3000.0, rate_per_s=1000.0),
)


class TesterSettings(Settings):
    """Settings and faults of the tester."""

    seed: int = 0
    """Of the noise."""
    rate: float = 2000.0
    """Samples in a second."""
    simulate: Literal["", "unplugged"] = ""
    """Simulate a device that does not answer."""
    slip: AnyQuantity | None = None
    """By how much the true frequency differs from the one that is set."""


class Tester:
    """Turns at a frequency under a load."""

    non_blocking = True
    channels = CHANNELS
    drives = DRIVES

    def __init__(self, settings, context):
        self.settings, self.clock = settings, context.clock
        self.sample_rate_hz = settings.rate
        self._drives = Drives(DRIVES, context.clock)
        self._streams, self._readings = Counter(), Counter()
        self._connected = False

    def connect(self, timeout_s):
        if self.settings.simulate:
            raise DeviceNotFoundError(f"no answer within {timeout_s:g} s")
        self._connected = True
        self._streams.clear()
        self._readings.clear()
        return Identity("Tests", "tester of tests", "1", simulated=True)

    def close(self):
        self._connected = False

    def make_safe(self):
        return self._drives.make_safe()

    def set(self, drive, value):
        self._need()
        self._drives.set(drive, value)

    def read_back(self, drive):
        self._need()
        return self._drives.read_back(drive)

    def read(self, channels):
        check_channels(channels, CHANNELS)
        place = self._place()
        self._readings[place] += 1
        number = 1000 * (1 + self._streams[place]) + self._readings[place]
        values = self._samples(1, number)
        return {name: float(values[name][0]) for name in channels}

    def stream(self, channels, duration_s, stop):
        check_channels(channels, CHANNELS)
        place = self._place()
        self._streams[place] += 1
        values = self._samples(round(duration_s * self.sample_rate_hz), self._streams[place])
        values_by_name = {name: values[name] for name in channels}
        return paced_blocks(values_by_name, self.sample_rate_hz, self.clock, stop)

    def continue_after(self, streams):
        for setpoints in streams:
            self._streams[setpoints.get("frequency", 0.0), setpoints.get("load", 0.0)] += 1

    def pause(self):
        self._need()

    def resume(self):
        self._need()

    def _need(self):
        if not self._connected:
            raise DeviceLostError("the tester is not connected")

    def _place(self):
        self._need()
        actual = self._drives.actual
        return actual["frequency"], actual["load"]

    def _samples(self, count, number):
        frequency_hz, load_n = self._place()
        true_hz = frequency_hz * (1 + (self.settings.slip.si if self.settings.slip else 0.0))
        phase = 2 * np.pi * true_hz * np.arange(count) / self.sample_rate_hz
        turning_nm = (IDLE_NM + PER_NEWTON_NM * load_n) if frequency_hz else 0.0
        true = {
            "angle": SWING_RAD * np.sin(phase),
            "torque": OFFSET_NM + turning_nm + SINE_NM * np.sin(phase),
            "load": load_n,
            "temperature": TEMPERATURE_K,
        }
        seed = [self.settings.seed, round(1e3 * frequency_hz), round(1e3 * load_n), number]
        rng = np.random.default_rng(seed)
        return {name: value + NOISE[name] * rng.standard_normal(count)
                for name, value in true.items()}  # fmt: skip


@hookimpl
def rigrunner_devices():
    """Return the tester."""
    return [
        DeviceRecord(
            name="tester_of_tests",
            help="Turns at a frequency under a load; the torque is known by construction",
            settings=TesterSettings,
            factory=Tester,
            simulated=True,
            absent={"simulate": "unplugged"},
        )
    ]
