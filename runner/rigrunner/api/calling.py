"""How a device is called: inline, or from a thread of its own with a time limit on each call.

The rig calls the devices of a station so, and a device made of several calls its parts.
"""

from __future__ import annotations

import sys
import threading
import time
from concurrent.futures import Future, wait
from contextlib import suppress
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from rigrunner.api.errors import DeviceError, DeviceLostError, DeviceTimeoutError

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from rigrunner.api.data import Block
    from rigrunner.api.devices import StopToken, Streaming

_T = TypeVar("_T")
_Job = tuple["Callable[[], Any]", "Future[Any]"]


class Caller(Protocol):
    """Calls one device, one call at a time."""

    def call(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Return what the function returns; raise DeviceTimeoutError if that takes too long."""
        ...

    def call_urgently(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Do the same even while an earlier call hangs: for what makes safe and closes."""
        ...

    def start(self, what: str, function: Callable[[], _T]) -> Future[_T]:
        """Begin the call and return at once; what it gives, or raises, is in the future."""
        ...

    def stop(self) -> None:
        """Let go of the thread, if there is one."""
        ...


class Call(Protocol):
    """Calls one known device: what it is for, what to do, and how long that may take."""

    def __call__(
        self, what: str, function: Callable[[], _T], timeout_s: float | None = None, /
    ) -> _T:
        """Return what the function returns; raise a DeviceError. None: the usual time."""
        ...


def blocks_of(  # noqa: PLR0917  (a stream, how to call, and how long)
    device: Streaming,
    channels: Sequence[str],
    duration_s: float,
    stop: StopToken,
    call: Call,
    timeout_s: float,
) -> Generator[Block]:
    """Yield the blocks of a stream, each within the time limit; end it on every way."""
    blocks = call("start the stream", lambda: iter(device.stream(channels, duration_s, stop)))
    try:
        while block := call("stream", lambda: next(blocks, None), timeout_s):
            yield block
    finally:
        close = getattr(blocks, "close", None)
        if close is not None:
            with suppress(DeviceError):  # a device that hangs has said so already
                call("end the stream", close)


class InlineCaller:
    """Calls a device that declares itself non-blocking."""

    def call(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:  # noqa: ARG002  (the Protocol's)
        """Return what the function returns."""
        return function()

    call_urgently = call

    def start(self, what: str, function: Callable[[], _T]) -> Future[_T]:  # noqa: ARG002  (the Protocol's)
        """Do it, and return what it gave."""
        future = Future[_T]()
        _settle(future, function)
        return future

    def stop(self) -> None:
        """Do nothing: there is no thread."""


class ThreadCaller:
    """Calls a device from one daemon thread; a call that hangs is abandoned, not waited for."""

    grace_s = 2.0
    """How long an urgent call waits for the one before it."""
    _slice_s: float | None = 0.1 if sys.platform == "win32" else None
    """How long is waited at a stretch: on Windows no signal breaks a wait off, nor does Stop."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._jobs: SimpleQueue[_Job | None] | None = None
        self._last: Future[Any] | None = None
        self._hangs = ""

    def call(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Call; raise DeviceTimeoutError, and from then on DeviceLostError."""
        self._refuse_after_hanging(what)
        return self._run(what, function, timeout_s)

    def call_urgently(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Call, from a fresh thread if the one before does not come back within `grace_s`."""
        if self._last is not None and not self._hangs:
            wait([self._last], self.grace_s)
        if self._last is not None and not self._last.done():
            self._hangs = self._hangs or "a call that was interrupted"
            self.stop()
        return self._run(what, function, timeout_s)

    def start(self, what: str, function: Callable[[], _T]) -> Future[_T]:
        """Begin the call after those before it; raise DeviceLostError if one of them hangs."""
        self._refuse_after_hanging(what)
        future = Future[_T]()
        self._last = future
        self._queue().put((function, future))
        return future

    def stop(self) -> None:
        """Let the thread end after its present call; the next call starts a new one."""
        if self._jobs is not None:
            self._jobs.put(None)
        self._jobs = self._last = None

    def _refuse_after_hanging(self, what: str) -> None:
        if self._hangs:
            raise DeviceLostError(f"cannot {what}: an earlier call, '{self._hangs}', still hangs")

    def _run(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        self._last = future = Future[Any]()
        self._queue().put((function, future))
        try:
            left_s = self._wait_in_slices(future, timeout_s)
            return future.result(left_s)  # type: ignore[no-any-return]  # one queue, many types
        except TimeoutError:
            if future.done():
                return future.result()  # type: ignore[no-any-return]  # came late, or its own error
            future.cancel()
            self._hangs = self._hangs or what
            raise DeviceTimeoutError(f"'{what}' did not return within {timeout_s:.3g} s") from None

    def _wait_in_slices(self, future: Future[Any], timeout_s: float) -> float:
        """Return what is left of the time; all of it where a wait can be broken off."""
        if self._slice_s is None:
            return timeout_s
        end_s = time.monotonic() + timeout_s
        while not future.done() and (left_s := end_s - time.monotonic()) > 0:
            wait([future], min(self._slice_s, left_s))
        return 0.0

    def _queue(self) -> SimpleQueue[_Job | None]:
        if self._jobs is None:
            self._jobs = SimpleQueue()
            threading.Thread(
                target=_work, args=(self._jobs,), name=f"device {self._name}", daemon=True
            ).start()
        return self._jobs


def _work(jobs: SimpleQueue[_Job | None]) -> None:
    while (job := jobs.get()) is not None:
        function, future = job
        if not future.set_running_or_notify_cancel():
            continue
        _settle(future, function)


def _settle(future: Future[_T], function: Callable[[], _T]) -> None:
    try:
        future.set_result(function())
    except BaseException as error:  # noqa: BLE001  (handed to the caller, whatever it is)
        future.set_exception(error)
