"""Calls of devices: inline, or in a thread with a time limit for each call.

The rig calls the devices of a station this way, and a composite device its parts.
"""

from __future__ import annotations

import math
import sys
import threading
import time
from concurrent.futures import Future, wait
from functools import partial
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from rigrunner.api.cleanup import noted_on
from rigrunner.api.errors import DeviceLostError, DeviceTimeoutError

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Sequence

    from rigrunner.api.data import Block
    from rigrunner.api.devices import StopToken, Streaming

_T = TypeVar("_T")

_LATE_S = 2.0
"""A wait that ends this much later than requested is not the fault of a device."""


class Caller(Protocol):
    """Calls one device, one call at a time."""

    def call(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Return the result of the function; raise DeviceTimeoutError if it takes too long."""
        ...

    def call_urgently(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Call even while an earlier call hangs: for make_safe and close."""
        ...

    def start(self, what: str, function: Callable[[], _T]) -> Future[_T]:
        """Start the call and return at once; the future has its result or exception."""
        ...

    def stop(self) -> None:
        """Release the thread, if there is one."""
        ...


class Call(Protocol):
    """Calls a certain device, with a purpose, a function and a time limit."""

    def __call__(
        self, what: str, function: Callable[[], _T], timeout_s: float | None = None, /
    ) -> _T:
        """Return the result of the function; raise a DeviceError. None: the usual time limit."""
        ...


def blocks_of(  # noqa: PLR0917  (a stream, how to call, and how long)
    device: Streaming,
    channels: Sequence[str],
    duration_s: float,
    stop: StopToken,
    call: Call,
    timeout_s: float,
) -> Generator[Block]:
    """Yield the blocks of a stream, each within the time limit; always end the stream."""
    blocks = call("start the stream", lambda: iter(device.stream(channels, duration_s, stop)))
    try:
        while block := call("stream", lambda: next(blocks, None), timeout_s):
            yield block
    except BaseException as error:
        with noted_on(error, "ending the stream"):
            _end(blocks, call)
        raise
    _end(blocks, call)


def _end(blocks: Iterator[Block], call: Call) -> None:
    close = getattr(blocks, "close", None)
    if close is not None:
        call("end the stream", close)


class InlineCaller:
    """Calls a device that declares itself non-blocking."""

    def call(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:  # noqa: ARG002  (the Protocol's)
        """Return the result of the function."""
        return function()

    call_urgently = call

    def start(self, what: str, function: Callable[[], _T]) -> Future[_T]:  # noqa: ARG002  (the Protocol's)
        """Call the function and return its result in a future."""
        future = Future[_T]()
        _settle(future, function)
        return future

    def stop(self) -> None:
        """Do nothing: there is no thread."""


class ThreadCaller:
    """Calls a device in one daemon thread; a call that hangs is abandoned."""

    grace_s = 2.0
    """Time that an urgent call waits for the one before it."""
    _slice_s: float | None = 0.1 if sys.platform == "win32" else None
    """Waiting is sliced, since on Windows neither a signal nor Stop interrupts it."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._jobs: SimpleQueue[Callable[[], None] | None] | None = None
        self._last: Future[Any] | None = None
        self._hangs = ""

    def call(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Call; raise DeviceTimeoutError, and DeviceLostError for later calls."""
        self._refuse_after_hanging(what)
        return self._run(what, function, timeout_s)

    def call_urgently(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Call, in a new thread if the call before does not return within `grace_s`."""
        grace_s = 0.0 if self._hangs else self.grace_s  # a call that hangs was waited for already
        if self._last is not None and not _is_over(self._last, grace_s):
            self._hangs = self._hangs or "a call that was interrupted"
            self.stop()
        return self._run(what, function, timeout_s)

    def start(self, what: str, function: Callable[[], _T]) -> Future[_T]:
        """Queue the call behind earlier ones; raise DeviceLostError if one of them hangs."""
        self._refuse_after_hanging(what)
        future = Future[_T]()
        self._send(partial(_settle, future, function))
        return future

    def stop(self) -> None:
        """End the thread after its present call; the next call starts a new one."""
        if self._jobs is not None:
            self._jobs.put(None)
        self._jobs = self._last = None

    def _refuse_after_hanging(self, what: str) -> None:
        if self._hangs:
            raise DeviceLostError(f"cannot {what}: an earlier call, '{self._hangs}', still hangs")

    def _run(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        call, end_s = self._send(function), time.monotonic() + timeout_s
        try:
            is_over = self._is_over(call, timeout_s)
        except BaseException:  # Ctrl-C, or a signal
            call.cancel()
            raise
        if not is_over:
            call.cancel()  # if it has not begun by now, it never does
            self._hangs = self._hangs or what
            late_s = time.monotonic() - end_s
            stopped = (
                "the device may have answered: this program itself was stopped or had no processor"
                f" for {late_s:.3g} s"
            )
            raise DeviceTimeoutError(
                f"'{what}' did not return within {timeout_s:.3g} s",
                hint=stopped if late_s > _LATE_S else "",
            )
        return call.result()

    def _send(self, function: Callable[[], _T]) -> Future[_T]:
        """Queue a call for the thread."""
        if self._jobs is None:
            self._jobs = SimpleQueue()
            threading.Thread(
                target=_work, args=(self._jobs,), name=f"device {self._name}", daemon=True
            ).start()
        self._last = call = Future[_T]()
        self._jobs.put(partial(_settle, call, function))
        return call

    def _is_over(self, call: Future[Any], timeout_s: float) -> bool:
        """Wait for a call at most that long; return whether it has ended."""
        if self._slice_s is None:
            return _is_over(call, timeout_s)
        end_s = time.monotonic() + timeout_s
        while (left_s := end_s - time.monotonic()) > 0:
            if _is_over(call, min(self._slice_s, left_s)):
                return True
        return _is_over(call)


class MovingCall:
    """A call that moves a drive, and may still do so after its time limit."""

    def __init__(self, what: str, function: Callable[[], Any], timeout_s: float) -> None:
        self.what = what
        self._function = function
        self._until_s = time.monotonic() + timeout_s
        self._returned = threading.Event()
        self.has_begun = False
        """False if it was refused because an earlier call hangs."""

    def __call__(self) -> Any:
        """Call the function."""
        self.has_begun = True
        try:
            return self._function()
        finally:
            self._returned.set()

    @property
    def has_returned(self) -> bool:
        """Whether it has ended in any way."""
        return self._returned.is_set()

    def wait(self, grace_s: float) -> None:
        """Wait for the rest of its time limit, and a grace period."""
        left_s = max(self._until_s - time.monotonic(), 0.0) + grace_s
        # A time limit may be infinite; a longer wait than this is an OverflowError.
        self._returned.wait(min(left_s, threading.TIMEOUT_MAX))


class MovingCalls:
    """The calls of a device that move its drives, one of which may end after its time limit."""

    def __init__(self) -> None:
        self._calls: list[MovingCall] = []

    @property
    def late(self) -> MovingCall | None:
        """The call that exceeded its time limit and has not returned yet.

        Later calls of the device are refused and move nothing.
        """
        calls = (call for call in self._calls if call.has_begun and not call.has_returned)
        return next(calls, None)

    def next(self, what: str, function: Callable[[], _T], timeout_s: float) -> Callable[[], _T]:
        """Return a call of the same function, as the next one."""
        moving = MovingCall(what, function, timeout_s)
        self._calls = [*(call for call in self._calls if not call.has_returned), moving]
        return moving


def _is_over(call: Future[Any], within_s: float = 0.0) -> bool:
    """Wait at most that long; return whether the thread has executed or skipped a call."""
    longest_s = None if within_s == math.inf else max(within_s, 0.0)
    return bool(wait([call], longest_s).done)


def _work(jobs: SimpleQueue[Callable[[], None] | None]) -> None:
    while (job := jobs.get()) is not None:
        job()


def _settle(future: Future[_T], function: Callable[[], _T]) -> None:
    if not future.set_running_or_notify_cancel():
        return
    try:
        future.set_result(function())
    except BaseException as error:  # noqa: BLE001  (any error is handed to the caller)
        future.set_exception(error)
