"""A tester that streams at 1 MS/s per channel in real time: a plugin of one file.

One second of the simulated rig, through a 16-bit converter, is made beforehand and streamed
repeatedly. Like the buffer of a driver it holds samples until they are fetched, and reports an
overflow after one second.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.data import Block
from rigrunner.api.errors import DeviceLostError
from rigrunner.api.hooks import DeviceRecord, hookimpl
from rigrunner_bearings.devices.simulated.tester import SimulatedTester
from rigrunner_bearings.devices.swing_tester_sim.rig import closed_form_rig
from rigrunner_bearings.devices.swing_tester_sim.settings import SwingTesterSimSettings

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.devices import DeviceContext, StopToken

api_version = 1
BUFFER_S = 1.0
BITS = 16
FULL_SCALES = {"angle": 0.1, "velocity": 20.0, "load": 3000.0, "torque": 12.0}


class FastTesterSettings(SwingTesterSimSettings):
    """The settings of the simulated rig, and of the stream."""

    paced: bool = True
    """Whether a block comes after its time has passed, or immediately."""
    block_samples: int = 100_000


class FastTester(SimulatedTester):
    """The simulated rig with a stream from memory."""

    non_blocking = False

    def __init__(self, settings: FastTesterSettings, context: DeviceContext) -> None:
        super().__init__("fast_tester", settings, closed_form_rig(settings.parameters()), context)
        self._paced, self._block = settings.paced, settings.block_samples
        self._seconds: dict[tuple[float, float], Mapping[str, np.ndarray]] = {}
        self._produced = 0
        self._late_s = 0.0

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        second = self.second()
        return self._blocks({name: second[name] for name in channels}, duration_s, stop)

    def stream_conditions(self) -> Mapping[str, tuple[float, str]]:
        """Return the number of samples made, and the longest delay of a fetch."""
        return {"produced": (float(self._produced), "1"), "late": (self._late_s, "s")}

    def _blocks(
        self, second: Mapping[str, np.ndarray], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        rate_hz, self._produced, self._late_s = self.sample_rate_hz, 0, 0.0
        total, began_s = round(duration_s * rate_hz), time.monotonic()
        while self._produced < total and not stop.is_set():
            first, start = self._produced, self._produced % round(rate_hz)
            count = min(self._block, total - first, round(rate_hz) - start)
            due_s = began_s + (first + count) / rate_hz
            self._wait(due_s)
            self._produced += count
            channels = {name: values[start : start + count] for name, values in second.items()}
            yield Block(rate_hz, first, due_s - count / rate_hz, channels)

    def _wait(self, due_s: float) -> None:
        late_s = time.monotonic() - due_s
        if not self._paced:
            return
        if late_s > BUFFER_S:
            raise DeviceLostError(f"the buffer ran over: a block was fetched {late_s:.2f} s late")
        self._late_s = max(self._late_s, late_s)
        if late_s < 0:
            time.sleep(-late_s)

    def second(self) -> Mapping[str, np.ndarray]:
        """Return one second of every channel at the current set-points."""
        state = self._state()
        setpoints = (state.frequency_hz, state.load_n)
        if setpoints not in self._seconds:
            samples = self._sample(state, round(self.sample_rate_hz), 0, FULL_SCALES)
            self._seconds[setpoints] = {
                name: _digitise(name, samples[name]) for name in FULL_SCALES
            }
        return self._seconds[setpoints]


def _digitise(name: str, values: np.ndarray) -> np.ndarray:
    step = 2 * FULL_SCALES[name] / 2**BITS
    return step * np.round(values / step)


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    return [
        DeviceRecord(
            name="fast_tester",
            help="Swing tester at 1 MS/s, streamed from memory",
            settings=FastTesterSettings,
            factory=FastTester,
            simulated=True,
        )
    ]
