"""Turns blocks of samples into frames for screens, and limits how often they are sent."""

from __future__ import annotations

import json
import struct
import threading
import time
from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.units import from_si
from rigrunner_panel.live.trend import STEP_S, Trend

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from rigrunner.api.events import Samples
    from rigrunner.api.figures import Axis, Curve

WAITING_CURVES = 4
"""Most curves of one block to show; older ones are dropped."""
X = "x"
"""The array of a curve with the values of x; the others are its series, by name."""

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
        self._channel = self._unit = ""
        """The channel of the trend."""
        self._waiting: deque[bytes] = deque(maxlen=WAITING_CURVES)
        self._latest: dict[str, tuple[dict[str, Any], Mapping[str, NDArray[Any]], float]] = {}
        """By title: header, arrays, and when it was drawn, by the clock of this process."""

    def take(self, event: Samples, start_s: float, units: Mapping[str, str]) -> None:
        """Add a block whose first sample was taken at `start_s` seconds of the run.

        The trend shows the first channel of `units` in the block, or else its first channel.
        """
        channels = event.block.channels
        if not channels:
            return
        name = next((channel for channel in units if channel in channels), next(iter(channels)))
        unit = units.get(name, "")
        zero, one = (from_si(0.0, unit), from_si(1.0, unit)) if unit else (0.0, 1.0)
        shown = (np.asarray(channels[name], float) * (one - zero) + zero).astype(np.float32)
        with self._lock:
            if name != self._channel:
                self._trend = Trend()
            self._channel, self._unit = name, unit
            first = self._trend.take(start_s, event.block.rate_hz, shown)
            self._touched = first if self._touched is None else min(first, self._touched)

    def draw(self, recording: str, curve: Curve, ended_s: float, late_s: float = 0.0) -> None:
        """Add a curve of a recording that ended at `ended_s`, by the clock of the events.

        It arrives `late_s` later; 0 in simulated time.
        """
        header = {
            "kind": "curve",
            "recording": recording,
            "title": curve.title,
            "x": _axis(curve.x),
            "y": _axis(curve.y),
            "frequency_hz": curve.frequency_hz,
            "t_s": curve.end_s,
            "monotonic_s": ended_s,
            "late_s": round(late_s, 3),
        }
        arrays = {X: curve.at, **curve.series}
        drawn = frame(header, arrays)
        with self._lock:
            self._latest[curve.title] = (header, arrays, time.monotonic())
            self._waiting.append(drawn)

    def all_frames(self) -> list[bytes]:
        """Return the frames for a screen that has no data yet."""
        with self._lock:
            latest = []
            for header, arrays, drawn_s in self._latest.values():
                late_s = header["late_s"] + time.monotonic() - drawn_s
                latest.append(frame({**header, "late_s": round(late_s, 3)}, arrays))
            return [self._trend_frame(0, reset=True), *latest]

    def next_curve(self) -> bytes | None:
        """Return the next curve to show, if any."""
        with self._lock:
            return self._waiting.popleft() if self._waiting else None

    def next_trend(self) -> bytes | None:
        """Return the columns that changed since the last call, if any."""
        with self._lock:
            if self._touched is None:
                return None
            first, self._touched = self._touched, None
            return self._trend_frame(first, reset=False)

    def _trend_frame(self, first: int, *, reset: bool) -> bytes:
        first, low, high = self._trend.since(first)
        header = {
            "kind": "trend",
            "first": first,
            "step_s": STEP_S,
            "reset": reset,
            "channel": self._channel,
            "unit": self._unit,
        }
        return frame(header, {"minimum": low, "maximum": high})


def _axis(axis: Axis) -> dict[str, Any]:
    return {"name": axis.name, "unit": axis.unit, "low": axis.low, "high": axis.high}
