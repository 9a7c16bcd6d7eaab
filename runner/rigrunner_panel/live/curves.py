"""Turns blocks of samples into frames for screens, and limits how often they are sent."""

from __future__ import annotations

import json
import struct
import threading
from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner_panel.live.swing import PHASES, SwingCutter
from rigrunner_panel.live.trend import STEP_S, Trend

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from rigrunner.api.events import Samples
    from rigrunner_panel.live.swing import Swing

    Floats = NDArray[np.floating]

WAITING_SWINGS = 4
"""Most swings of one block to show; older ones are dropped."""

_ALIGN = 4


def frame(header: Mapping[str, Any], arrays: Mapping[str, NDArray[np.floating[Any]]]) -> bytes:
    """Return curves as a binary frame: the length of a JSON header, the header, and float32 arrays.

    Numbers are little-endian; each array has the shape (n,).
    """
    listed = [[name, len(values)] for name, values in arrays.items()]
    text = json.dumps({**header, "arrays": listed}, allow_nan=False).encode()
    text += b" " * (-len(text) % _ALIGN)
    parts = [np.ascontiguousarray(values, "<f4").tobytes() for values in arrays.values()]
    return struct.pack("<I", len(text)) + text + b"".join(parts)


class Curves:
    """The live curves of one job, bounded in size. One thread writes, another reads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._trend = Trend()
        self._touched: int | None = None
        self._channel = ""
        """What is over time, where it is no torque: the first channel that is recorded."""
        self._swings: deque[bytes] = deque(maxlen=WAITING_SWINGS)
        self._cutter: SwingCutter | None = None
        self._key: tuple[str, float] | None = None
        self._next_sample = 0
        self._corrections: tuple[str, Floats] | None = None
        self._latest: bytes | None = None
        self.frequency_hz: float | None = None

    def begin(self, recording: str, frequency_hz: float | None) -> None:
        """Start a recording, at a set frequency if the rig swings."""
        with self._lock:
            self._key = (recording, frequency_hz) if frequency_hz else None
            self._cutter = None
            self.frequency_hz = None

    def correct(self, recording: str, correction_nm: Floats) -> None:
        """Subtract the correction of the analysis from the swings of a recording."""
        phases = np.arange(PHASES) * len(correction_nm) / PHASES
        places = np.arange(len(correction_nm) + 1)
        closed = np.append(correction_nm, correction_nm[0])
        with self._lock:
            self._corrections = (recording, np.interp(phases, places, closed))

    def take(self, event: Samples, start_s: float) -> None:
        """Add a block whose first sample was taken at `start_s` seconds of the run."""
        block = event.block
        torque = _channel(event, "torque")
        if not block.channels:
            return
        name, first_channel = next(iter(block.channels.items()))
        with self._lock:
            self._channel = "" if torque is not None else name
            values = np.asarray(first_channel, np.float32) if torque is None else torque
            first = self._trend.take(start_s, block.rate_hz, values)
            self._touched = first if self._touched is None else min(first, self._touched)
            if torque is not None:
                self._cut(event, torque)

    def whole(self) -> list[bytes]:
        """Return the frames for a screen that has no data yet."""
        with self._lock:
            trend = self._trend_frame(0, reset=True)
            return [trend] if self._latest is None else [trend, self._latest]

    def next_swing(self) -> bytes | None:
        """Return the next swing to show, if any."""
        with self._lock:
            return self._swings.popleft() if self._swings else None

    def next_trend(self) -> bytes | None:
        """Return the columns that changed since the last call, if any."""
        with self._lock:
            if self._touched is None:
                return None
            first, self._touched = self._touched, None
            return self._trend_frame(first, reset=False)

    def _trend_frame(self, first: int, *, reset: bool) -> bytes:
        first, low, high = self._trend.since(first)
        header = {"kind": "trend", "first": first, "step_s": STEP_S, "reset": reset}
        if self._channel:
            header["channel"] = self._channel
        return frame(header, {"min_nm": low, "max_nm": high})

    def _cut(self, event: Samples, torque: NDArray[np.float32]) -> None:
        block = event.block
        if self._key is None or self._key[0] != event.recording:
            return
        if self._cutter is None or block.first_sample != self._next_sample:
            self._cutter = SwingCutter(block.rate_hz, self._key[1])
        self._next_sample = block.first_sample + len(torque)
        for swing in self._cutter.take(torque, _channel(event, "angle")):
            self.frequency_hz = swing.frequency_hz
            since_s = (self._next_sample - swing.end_s * block.rate_hz) / block.rate_hz
            self._latest = self._swing_frame(event.recording, swing, event.monotonic_s - since_s)
            self._swings.append(self._latest)

    def _swing_frame(self, recording: str, swing: Swing, ended_s: float) -> bytes:
        arrays: dict[str, Floats] = {"raw_nm": swing.raw_nm}
        if swing.angle_rad is not None:
            arrays["angle_rad"] = swing.angle_rad
        if self._corrections is not None and self._corrections[0] == recording:
            arrays["compensated_nm"] = swing.raw_nm - self._corrections[1]
        header = {
            "kind": "swing",
            "recording": recording,
            "frequency_hz": swing.frequency_hz,
            "t_s": swing.end_s,
            "monotonic_s": ended_s,
        }
        return frame(header, arrays)


def _channel(event: Samples, name: str) -> NDArray[np.float32] | None:
    """Return the channel with that name, of any role."""
    found = (each for full, each in event.block.channels.items() if full.endswith(f".{name}"))
    shown = next(found, None)
    return None if shown is None else np.asarray(shown, np.float32)
