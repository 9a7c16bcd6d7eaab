"""The common part of all streaming drivers: gapless blocks, stop, and end."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from rigrunner.api.cleanup import noted_on
from rigrunner.api.data import Block
from rigrunner.api.driver import Driver
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.api.samples import as_samples

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.data import Array
    from rigrunner.api.devices import StopToken


class StreamingDriver(Driver):
    """A Streaming Driver; implement `sample_rate_hz`, `start`, `take` and `halt`.

    Each block goes over the wire.
    """

    block_s: ClassVar[float] = 0.1
    """Duration of a block; the run is checked between blocks."""

    reads_back_while_streaming: ClassVar[bool] = False
    """Whether `actual` may be called between blocks, so that drives are monitored meanwhile.

    Any streaming device can have this attribute.
    """

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel, by the clock of the instrument."""
        raise NotImplementedError

    def start(self, channels: Sequence[str]) -> None:
        """Start sampling these channels."""

    def take(self, channels: Sequence[str], samples: int) -> Mapping[str, Array]:
        """Wait for the next samples of each channel and return them, shape (samples,).

        They follow the samples returned before without a gap; raise a DeviceError if some were
        lost.
        """
        raise NotImplementedError

    def halt(self) -> None:
        """Stop sampling: called at every end of a stream, also after `start` failed."""

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield gapless blocks until the duration has passed or the token is set.

        The time of a block is that of its arrival.
        """
        # Not a generator itself: a wrong channel is refused here, not with the first block.
        self.check_channels(channels)
        return self._blocks(tuple(channels), round(duration_s * self.sample_rate_hz), stop)

    def _blocks(self, channels: Sequence[str], samples: int, stop: StopToken) -> Iterator[Block]:
        rate_hz, names, first = self.sample_rate_hz, ", ".join(channels), 0
        longest = max(1, round(self.block_s * rate_hz))
        try:
            self.exchange(f"start {names}", lambda: self.start(channels))
            while first < samples and not stop.is_set():
                count = min(longest, samples - first)
                values = self._take_samples(channels, count, f"take {count} of {names}")
                now_s = self.clock.monotonic_s()
                yield Block(rate_hz, first, now_s, dict(zip(channels, values, strict=True)))
                first += count
        except BaseException as error:
            with noted_on(error, "halting the stream"):
                self.exchange(f"halt {names}", self.halt)
            raise
        self.exchange(f"halt {names}", self.halt)

    def _take_samples(self, channels: Sequence[str], count: int, request: str) -> list[Array]:
        def perform() -> list[Array]:
            samples = self.take(channels, count)
            return [_real(name, samples[name]) for name in channels]

        values = self.exchange(request, perform)
        shapes = [array.shape for array in values]
        if shapes != [(count,)] * len(channels):
            raise DeviceRejectedError(
                f"{request}: got arrays of the shapes {shapes}, expected ({count},) for each"
            )
        return values


def _real(channel: str, values: object) -> Array:
    try:
        return as_samples(values)
    except TypeError as error:
        raise DeviceRejectedError(
            f"{channel}: the samples are {error}, expected real numbers"
        ) from error
