"""A process that works on one item after the other."""

from __future__ import annotations

import os
import signal
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any

from rigrunner.blas import ONE_THREAD
from rigrunner.ending import signal_name
from rigrunner.jobs.done import Answer, attempt

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from multiprocessing.connection import Connection

ENVIRONMENT = {**ONE_THREAD, "PYTHONSAFEPATH": "1"}
"""Environment variables of the process, for its interpreter and libraries.

Without the second one, a spawned interpreter imports modules of the current folder, where anybody
may have put them, before those of Python.
"""
END = None
"""Sent in place of an item: there are no more."""


class Worker:
    """The process, the pipe to it, and its item.

    It is spawned, since a fork may copy a lock that another thread holds.
    """

    def __init__(self, task: Callable[[Any], Any]) -> None:
        context = get_context("spawn")
        self.pipe, child_end = context.Pipe()
        self.place = self.attempt = -1
        self._process = context.Process(target=serve, args=(child_end,), daemon=True)
        # A process gets the environment of this one: `Process` takes no other.
        with _environment():
            self._process.start()
        child_end.close()  # or the death of the process would not end the pipe
        self._send(task)

    def give(self, place: int, item: Any, attempt: int) -> None:
        """Give it the item at that index, and count the attempt."""
        self.place, self.attempt = place, attempt
        self._send((item,))

    def answer(self) -> Answer[Any] | None:
        """Return its answer, or None if the process died."""
        try:
            answer: Answer[Any] = self.pipe.recv()
        except (EOFError, OSError):
            return None
        return answer

    def death(self) -> str:
        """Return how the dead process ended, as text."""
        self.pipe.close()
        self._process.join()
        code = self._process.exitcode or 0
        if code < 0:
            return f"the process was ended by {signal_name(-code)}"
        return f"the process ended with {code}"

    def end(self) -> None:
        """Let the process end after its last item."""
        self._send(END)
        self.pipe.close()
        self._process.join()

    def kill(self) -> None:
        """Kill the process."""
        self._process.kill()
        self._process.join()
        self.pipe.close()

    def _send(self, what: Any) -> None:
        with suppress(OSError):  # if it died meanwhile, reading the pipe reports it
            self.pipe.send(what)


def serve(pipe: Connection) -> None:
    """Take a task from the pipe, then answer items until the last one, or until the pipe closes."""
    # Ctrl-C goes to every process of a terminal; the one that sends the items handles it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    task = _task(pipe)
    with suppress(EOFError, OSError):
        while (arguments := pipe.recv()) is not END:
            pipe.send(attempt(task, *arguments))


def _task(pipe: Connection) -> Callable[[Any], Any]:
    """Return the task from the pipe; if it cannot be imported, each item reports that."""
    try:
        task: Callable[[Any], Any] = pipe.recv()
    except Exception as error:  # noqa: BLE001  (whatever a module raises when it is imported)
        failure = error

        def task(_: Any) -> Any:
            raise failure

    return task


@contextmanager
def _environment() -> Iterator[None]:
    """Start the process with these environment variables."""
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
