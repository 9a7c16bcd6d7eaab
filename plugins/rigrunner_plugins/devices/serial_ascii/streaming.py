"""Recordings of an instrument that sends lines at a known rate."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Block, DeviceError, DeviceRejectedError
from rigrunner_plugins.devices.serial_ascii.device import SerialAscii

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import DeviceContext, StopToken
    from rigrunner_plugins.devices.serial_ascii.line_buffer import Line
    from rigrunner_plugins.devices.serial_ascii.settings import SerialAsciiSettings

_UNEVEN_S = 0.15
"""By how much lines may come early or late: an adapter hands them over in portions."""
_UNEVEN = 0.02
"""The same, of the time since the first one: the instrument's clock is not ours."""


def make(settings: SerialAsciiSettings, context: DeviceContext) -> SerialAscii:
    """Return the instrument; one with a `rate` records."""
    if settings.rate is None:
        return SerialAscii(settings, context)
    return StreamingSerialAscii(settings, settings.rate, context)


class StreamingSerialAscii(SerialAscii):
    """An instrument whose lines come at a rate that the station declares, which is checked."""

    def __init__(
        self, settings: SerialAsciiSettings, rate_hz: float, context: DeviceContext
    ) -> None:
        super().__init__(settings, context)
        self._rate_hz = rate_hz

    @property
    def sample_rate_hz(self) -> float:
        """Lines per second."""
        return self._rate_hz

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield gapless blocks until the duration has passed or the token is set."""
        self.check_channels(channels)
        return self._blocks(tuple(channels), round(duration_s * self._rate_hz), stop)

    def _blocks(self, channels: Sequence[str], samples: int, stop: StopToken) -> Iterator[Block]:
        first, pace = 0, _Pace(self._rate_hz)

        def perform() -> list[str]:
            lines = self._open_lines().recorded()
            pace.check(lines)
            return [line.text for line in lines]

        self.exchange("record", lambda: self._open_lines().record())
        try:
            while first < samples and not stop.is_set():
                lines = self.exchange("recorded lines", perform)[: samples - first]
                rows = [self._settings.values_in(line) for line in lines]
                values = {name: np.array([row[name] for row in rows]) for name in channels}
                yield Block(self._rate_hz, first, self.clock.monotonic_s(), values)
                first += len(rows)
        except DeviceError:
            self._drop()  # whatever it was, what comes next begins again
            raise
        finally:
            if self._lines is not None:
                self._lines.stop_recording()


class _Pace:
    """Checks that lines come at the station's rate."""

    def __init__(self, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._first_s: float | None = None
        self._came = 0

    def check(self, lines: Sequence[Line]) -> None:
        """Take the next lines; raise DeviceRejectedError where too many or too few have come."""
        if self._first_s is None:
            self._first_s = lines[0].at_s
        self._came += len(lines)
        took_s, due_s = lines[-1].at_s - self._first_s, (self._came - 1) / self._rate_hz
        if abs(took_s - due_s) > _UNEVEN_S + _UNEVEN * max(took_s, due_s):
            raise DeviceRejectedError(
                f"{self._came} lines came in {took_s:.3g} s, at {self._rate_hz:g} Hz they take"
                f" {due_s:.3g} s: lines are lost, or `rate` is wrong",
                hint="count the lines per minute; is the baud rate high enough?",
            )
