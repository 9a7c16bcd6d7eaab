"""One instrument of a composite: each call has a time limit, and errors begin with its name."""

from __future__ import annotations

from contextlib import contextmanager
from functools import partial
from math import nan
from threading import Event
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api import (
    Approaching,
    DeviceError,
    DeviceLostError,
    DeviceRejectedError,
    Readable,
    Streaming,
)
from rigrunner.api.calling import InlineCaller, MovingCalls, ThreadCaller, blocks_of
from rigrunner.api.devices import KnowsStream

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
    from concurrent.futures import Future

    from rigrunner.api import Block, Device, DriveInfo, Identity, StopToken
    from rigrunner.api.calling import Caller, MovingCall
    from rigrunner.api.devices import Patience
    from rigrunner.api.readings import Reading

_T = TypeVar("_T")
_GLANCE_S = 0.1
"""Over which the mean is the single value of an instrument that only streams."""


class Part:
    """A device of its own thread, unless it cannot hang.

    A call that hangs is given up in time, and what makes safe is called all the same, from a fresh
    thread: one instrument that hangs keeps no other one from being made safe.
    """

    def __init__(self, name: str, role: str, device: Device, patience: Patience) -> None:
        self.name = name
        self.device: Any = device
        self._patience = patience
        self._streams = 0
        self._moving = MovingCalls()
        self._drives: dict[str, DriveInfo] = {info.name: info for info in device.drives}
        self._caller: Caller = (
            InlineCaller() if device.non_blocking else ThreadCaller(f"{role}/{name}")
        )

    def call(self, what: str, function: Callable[[], _T], timeout_s: float | None = None) -> _T:
        """Return what the function returns; raise a DeviceError that names the part."""
        limit_s = self._patience.answer_s if timeout_s is None else timeout_s
        with _prefixing_errors(self.name):
            return self._caller.call(what, function, limit_s)

    @property
    def is_inline(self) -> bool:
        """Whether it is called without a thread, as it cannot hang."""
        return isinstance(self._caller, InlineCaller)

    def ask(self, what: str, function: Callable[[], _T]) -> Future[_T]:
        """Begin a call and return at once; its `answer` is to be taken once it is done."""
        with _prefixing_errors(self.name):
            return self._caller.start(what, function)

    def answer(self, future: Future[_T]) -> _T:
        """Return what a call that is done gave; raise a DeviceError that names the part."""
        with _prefixing_errors(self.name):
            return future.result(0)

    def connect(self, timeout_s: float) -> Identity:
        """Open the connection and return the identity."""
        identity: Identity = self.call(
            "connect", lambda: self.device.connect(timeout_s), 2 * timeout_s
        )
        return identity

    def close(self) -> None:
        """Give the connection and the thread back."""
        try:
            with _prefixing_errors(self.name):
                self._caller.call_urgently("close", self.device.close, self._patience.answer_s)
        finally:
            self._caller.stop()

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return the present value of each channel; of one that only streams, a short mean."""
        if isinstance(self.device, Readable):
            readable = self.device
            return self.call("read", lambda: readable.read(channels))
        if self._streams:
            text = f"{self.name}: {', '.join(channels)} cannot be read while it records"
            raise DeviceRejectedError(text, hint="it gives single values by a stream of its own")
        totals, samples, never_set = dict.fromkeys(channels, 0.0), 0, Event()
        for block in self.stream(channels, _GLANCE_S, never_set):
            samples += block.samples
            for name in channels:
                totals[name] += float(block.channels[name].sum())
        if not samples:
            raise DeviceLostError(f"{self.name}: no sample came in {_GLANCE_S:g} s")
        return {name: total / samples for name, total in totals.items()}

    def observe(self, readings: Sequence[str]) -> Mapping[str, Reading]:
        """Return the present value of each reading."""
        return self.call("read", lambda: self.device.observe(readings))

    def begin(self, drive: str, value: float) -> None:
        """Give a drive a new set-point; return at once where the device can.

        To its safe value even while an earlier call hangs.
        """
        info, device = self._drives[drive], self.device
        urgent = value == info.safe_value
        call = self._caller.call_urgently if urgent else self._caller.call
        with _prefixing_errors(self.name):
            what, limit_s = f"set {drive}", self._patience.answer_s
            if isinstance(device, Approaching):
                move = partial(device.begin, drive, value)
            else:
                move, limit_s = partial(device.set, drive, value), limit_s + info.longest_s
            call(what, move if self.is_inline else self._moving.next(what, move, limit_s), limit_s)

    def arrived(self, drive: str) -> bool:
        """Return whether the drive is at its set-point, as the device itself sees it."""
        if not isinstance(self.device, Approaching):
            return True  # it was waited for
        return self.call(f"read back {drive}", lambda: bool(self.device.arrived(drive)))

    def read_back(self, drive: str) -> float:
        """Return the actual value of a drive, as the device itself reads it."""
        return self.call(f"read back {drive}", lambda: float(self.device.read_back(drive)))

    @property
    def late(self) -> MovingCall | None:
        """The call that moves a drive and was given up, if it has not come back."""
        return self._moving.late

    def make_safe_behind(self, late: MovingCall) -> Mapping[str, float]:
        """Make safe once more behind a set that was given up, which may have undone it.

        Raises DeviceRejectedError where that one does not come back: what was read back need not
        stay so.
        """
        late.wait(ThreadCaller.grace_s)
        if not late.has_returned:
            text = f"'{late.what}' was given up and has not come back: it may still move the drive"
            raise DeviceRejectedError(f"{self.name}: {text}")
        return self.make_safe()

    def make_safe(self) -> Mapping[str, float]:
        """Bring all its drives to their safe values, even while an earlier call hangs.

        Raises a DeviceError where one of them is not read back there, named by the role or not.
        """
        limit_s = self._patience.answer_s + sum(info.longest_s for info in self._drives.values())
        with _prefixing_errors(self.name):
            read_back: Mapping[str, float] = self._caller.call_urgently(
                "make safe", self.device.make_safe, limit_s
            )
            for name, info in self._drives.items():
                actual = read_back.get(name, nan)
                # Not `>`: a read-back of NaN is not safe either.
                if not abs(actual - info.safe_value) <= info.allowed_deviation:
                    text = f"{name} reads back {actual:g}, safe is {info.safe_value:g} {info.unit}"
                    raise DeviceRejectedError(text)
        return read_back

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Generator[Block]:
        """Yield the blocks of the device."""
        if not isinstance(self.device, Streaming):
            raise DeviceRejectedError(f"{self.name}: it does not stream")
        longest_s = self._patience.answer_s + duration_s
        with self.streaming():
            yield from blocks_of(self.device, channels, duration_s, stop, self.call, longest_s)

    @contextmanager
    def streaming(self) -> Iterator[None]:
        """Mark it as streaming: an instrument that only streams cannot be read meanwhile."""
        self._streams += 1
        try:
            yield
        finally:
            self._streams -= 1

    def stream_conditions(self) -> Mapping[str, tuple[float, str]]:
        """Return what the device reports of its last stream, by its own names."""
        if not isinstance(self.device, KnowsStream):
            return {}
        device = self.device
        return self.call("tell of the stream", lambda: dict(device.stream_conditions()))


@contextmanager
def _prefixing_errors(part: str) -> Iterator[None]:
    try:
        yield
    except DeviceError as error:
        error.message = f"{part}: {error.message}"
        raise
