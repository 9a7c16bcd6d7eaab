"""Recordings of an instrument behind VISA: blocks of samples that share one clock."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Block, DeviceLostError, DeviceRejectedError, DeviceTimeoutError
from rigrunner.api.cleanup import noted_on
from rigrunner_plugins.devices.channels import check_channels
from rigrunner_plugins.devices.text.commands import has_samples, with_samples
from rigrunner_plugins.devices.text.numbers import OVERLOAD, NumberInText, excerpt
from rigrunner_plugins.devices.visa.device import Visa

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Array, DeviceContext, StopToken
    from rigrunner_plugins.devices.visa.settings import Stream, VisaSettings


_EARLY_S = 0.05
"""By how much a block may come before its time: none can, but clocks have steps."""
_EARLY = 0.01
"""The same, of the time since the start: two clocks need not run alike."""


def make(settings: VisaSettings, context: DeviceContext) -> Visa:
    """Return the instrument; one with a `stream` records."""
    if settings.stream is None:
        return Visa(settings, context)
    return StreamingVisa(settings, settings.stream, context)


class StreamingVisa(Visa):
    """An instrument that records several channels on its own clock."""

    def __init__(self, settings: VisaSettings, stream: Stream, context: DeviceContext) -> None:
        super().__init__(settings, context)
        self._stream = stream

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        return self._stream.rate

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield gapless blocks until the duration has passed or the token is set."""
        self._need_connection()
        check_channels(channels, [self._channels[name] for name in self._stream.channels])
        return self._blocks(tuple(channels), round(duration_s * self._stream.rate), stop)

    def _blocks(self, channels: Sequence[str], samples: int, stop: StopToken) -> Iterator[Block]:
        stream, first = self._stream, 0
        started_s = self.clock.monotonic_s()
        # Stopped in any case: also where the start or a block failed.
        try:
            self.send(stream.start)
            while first < samples and not stop.is_set():
                values = self._fetch(min(stream.samples, samples - first), first, started_s)
                if stream.overrun is not None:
                    self.check(stream.overrun, "samples were lost")
                values = values[: samples - first]
                columns = dict(zip(stream.channels, values.T, strict=True))
                yield Block(
                    stream.rate,
                    first,
                    self.clock.monotonic_s(),
                    {name: self._settings.channels[name].to_si(columns[name]) for name in channels},
                )
                first += len(values)
        except BaseException as error:
            with noted_on(error, "stopping the acquisition"), self.without_setup():
                self.send(stream.stop)
            raise
        self.send(stream.stop)

    def _fetch(self, samples: int, first: int, started_s: float) -> Array:
        """Return the next samples, of shape (n, channels), n >= 1."""
        query = with_samples(self._stream.fetch, samples)
        limit_s = self._settings.timeout + samples / self._stream.rate

        def perform() -> bytes:
            if self._stream.format == "ascii":
                data = self._link.ask(query, limit_s).encode()
            else:
                data = self._link.ask_block(query, limit_s)
            # Within the exchange: a played-back one takes no time, and would seem to come too
            # early.
            self._check_pace(first + len(samples_in(data, self._stream, query)), started_s)
            return data

        try:
            data = self.exchange(f"fetch {query}", perform)
        except DeviceTimeoutError as error:
            self._explain(error)
            raise
        values = samples_in(data, self._stream, query)
        if len(values) == 0:
            raise DeviceLostError(f"'{query}' gives no more samples after {first}")
        # Without {samples} in it, a query gives whatever the instrument has by then.
        if len(values) > samples and has_samples(self._stream.fetch):
            raise DeviceRejectedError(f"'{query}' gives {len(values)} samples instead of {samples}")
        return values

    def _check_pace(self, samples: int, started_s: float) -> None:
        """Raise DeviceRejectedError for samples that come before they can have been taken."""
        elapsed_s, needed_s = self.clock.monotonic_s() - started_s, samples / self._stream.rate
        if self._stream.paced and elapsed_s < needed_s * (1 - _EARLY) - _EARLY_S:
            raise DeviceRejectedError(
                f"{samples} samples came after {elapsed_s:.3g} s; at {self._stream.rate:g} Hz"
                f" they take {needed_s:.3g} s",
                hint="is the sample rate of the instrument that of the station?",
            )


_CODES = {"float32": "f4", "float64": "f8", "int16": "i2", "int32": "i4"}
_PLAIN = NumberInText()


def samples_in(data: bytes, stream: Stream, query: str) -> Array:
    """Return the samples, of shape (n, channels), as the instrument's numbers.

    Raises DeviceRejectedError for data that are no whole number of samples, and for an overload.
    """
    numbers = _numbers(data, stream, query)
    channels = len(stream.channels)
    if numbers.size % channels:
        raise DeviceRejectedError(
            f"'{query}' gives {numbers.size} numbers, which is not a multiple of {channels}"
            f" channels: {', '.join(stream.channels)}",
            hint="which channels does the instrument record?",
        )
    values = numbers.reshape(-1, channels)
    # Not `>=`: a NaN compares with nothing, and is wrong too.
    wrong = np.argwhere(~(np.abs(values) < OVERLOAD))
    if len(wrong):
        sample, channel = wrong[0]
        raise DeviceRejectedError(
            f"{stream.channels[channel]} is {values[sample, channel]:g} in sample {sample} of a"
            " block: the instrument reports overload or 'not a number'",
            hint="choose a larger range, or check the wiring",
        )
    return values


def _numbers(data: bytes, stream: Stream, query: str) -> Array:
    if stream.format == "ascii":
        text = data.decode()
        what = f"in the answer to '{query}', {excerpt(text)}, a sample"
        fields = text.split(",") if text.strip() else []
        return np.array([_PLAIN.number_in(field, what) for field in fields], dtype=np.float64)
    code = _CODES[stream.format]
    size = int(code[1])
    if len(data) % size:
        raise DeviceRejectedError(
            f"the block that answers '{query}' has {len(data)} bytes,"
            f" which is not a multiple of the {size} of {stream.format}",
            hint="is `format` right?",
        )
    order = "<" if stream.byte_order == "little" else ">"
    return np.frombuffer(data, dtype=order + code).astype(np.float64)
