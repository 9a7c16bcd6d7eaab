"""Starts a child process of the panel and exchanges messages with it."""

from __future__ import annotations

import subprocess
import sys
import threading
from typing import TYPE_CHECKING

from rigrunner_panel.process.channel import Channel, ChannelClosedError

if TYPE_CHECKING:
    from collections.abc import Callable

PATIENCE_S = 10.0


class Process:
    """A child process with a channel, in its own session, so that Ctrl-C does not reach it."""

    def __init__(self, module: str) -> None:
        self._child = subprocess.Popen(  # noqa: S603  (our own interpreter and module)
            [sys.executable, "-P", "-m", module],  # -P: import nothing from the working folder
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),  # the same on Windows
        )
        assert self._child.stdin is not None  # noqa: S101  (both are pipes)
        assert self._child.stdout is not None  # noqa: S101  (likewise)
        self.channel = Channel(self._child.stdout, self._child.stdin)

    @property
    def pid(self) -> int:
        """The process id."""
        return self._child.pid

    def send(self, message: object) -> bool:
        """Send a message; return False if the process has ended."""
        try:
            self.channel.send(message)
        except ChannelClosedError:
            return False
        return True

    def listen(self, take: Callable[[object], None], ended: Callable[[int | None], None]) -> None:
        """Call `take` with each message, in a thread, then `ended` with the exit code."""

        def work() -> None:
            try:
                while True:
                    take(self.channel.receive())
            except ChannelClosedError:
                pass
            ended(self._wait())

        threading.Thread(target=work, name="from the rig's process", daemon=True).start()

    def close(self) -> int | None:
        """Close its input, wait, and return its exit code; None if it does not end in time."""
        self.channel.close()
        return self._wait()

    def _wait(self) -> int | None:
        """Wait for the exit code and close the pipes; None if it does not end in time."""
        try:
            code = self._child.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            return None
        self.channel.close()
        if self._child.stdout is not None:
            self._child.stdout.close()
        return code
