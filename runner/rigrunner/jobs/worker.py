"""A process that is given one item after the other."""

from __future__ import annotations

import os
import signal
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any

from rigrunner.blas import ONE_THREAD
from rigrunner.jobs.done import Answer, attempt

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from multiprocessing.connection import Connection

ENVIRONMENT = {**ONE_THREAD, "PYTHONSAFEPATH": "1"}
"""Of the process: its interpreter looks at it once, as do its libraries.

Without the second one an interpreter that is spawned imports modules of the folder that one stands
in before those of Python: there may be anybody's.
"""
END = None
"""Sent in place of an item: there are no more."""


class Worker:
    """The process, the pipe to it, and the item that it is at.

    It is spawned: a fork may copy a lock that another thread holds.
    """

    def __init__(self, task: Callable[[Any], Any]) -> None:
        context = get_context("spawn")
        self.pipe, its = context.Pipe()
        self.place = self.attempt = -1
        self._process = context.Process(target=serve, args=(its,), daemon=True)
        with _environment():
            self._process.start()
        its.close()  # or the death of the process would not end the pipe
        self._send(task)

    def give(self, place: int, item: Any, attempt: int) -> None:
        """Let it do the item at that place, counting the attempts at it."""
        self.place, self.attempt = place, attempt
        self._send((item,))

    def answer(self) -> Answer[Any] | None:
        """Return what it says of its item; None if it died over it."""
        try:
            answer: Answer[Any] = self.pipe.recv()
        except (EOFError, OSError):
            return None
        return answer

    def death(self) -> str:
        """Return how the process that is no more came to its end, in words."""
        self.pipe.close()
        self._process.join()
        code = self._process.exitcode or 0
        if code < 0:
            return f"the process was ended by {signal.Signals(-code).name}"
        return f"the process ended with {code}"

    def end(self) -> None:
        """Let it end, as there is nothing more to do."""
        self._send(END)
        self.pipe.close()
        self._process.join()

    def kill(self) -> None:
        """End it now, whatever it is at."""
        self._process.kill()
        self._process.join()
        self.pipe.close()

    def _send(self, what: Any) -> None:
        with suppress(OSError):  # it died meanwhile: reading the pipe will tell
            self.pipe.send(what)


def serve(pipe: Connection) -> None:
    """Take a task from the pipe, then answer items, until no more come or nobody listens."""
    # Ctrl-C goes to every process of a terminal; the one that asks decides what becomes of it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    task = _task(pipe)
    with suppress(EOFError, OSError):
        while (given := pipe.recv()) is not END:
            pipe.send(attempt(task, *given))


def _task(pipe: Connection) -> Callable[[Any], Any]:
    """Return what comes first through the pipe; where it cannot be imported, every item says so."""
    try:
        task: Callable[[Any], Any] = pipe.recv()
    except Exception as error:  # noqa: BLE001  (whatever a module raises when it is imported)
        failure = error

        def task(_: Any) -> Any:
            raise failure

    return task


@contextmanager
def _environment() -> Iterator[None]:
    """Let a process begin with our environment."""
    former = {name: os.environ.get(name) for name in ENVIRONMENT}
    os.environ.update(ENVIRONMENT)
    try:
        yield
    finally:
        for name, value in former.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
