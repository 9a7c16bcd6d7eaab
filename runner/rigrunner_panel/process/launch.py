"""Starts a process of this program and talks to it."""

from __future__ import annotations

import subprocess
import sys
import threading
from typing import TYPE_CHECKING, Any

from rigrunner_panel.process.channel import Channel, ChannelClosedError

if TYPE_CHECKING:
    from collections.abc import Callable

PATIENCE_S = 10.0


class Process:
    """A child with a channel. It is in a session of its own: Ctrl-C in the terminal is not its."""

    def __init__(self, module: str) -> None:
        self._child = subprocess.Popen(  # noqa: S603  (our own interpreter and module)
            [sys.executable, "-P", "-m", module],  # -P: no module of the folder that it is in
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),  # so on Windows
        )
        assert self._child.stdin is not None  # noqa: S101  (both are pipes)
        assert self._child.stdout is not None  # noqa: S101  (likewise)
        self._channel = Channel(self._child.stdout, self._child.stdin)

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._child.pid

    def send(self, message: object) -> bool:
        """Tell it something; return whether it is still there to hear."""
        try:
            self._channel.send(message)
        except ChannelClosedError:
            return False
        return True

    def ask(self, message: object) -> Any:
        """Return its answer; None if it is gone."""
        try:
            self._channel.send(message)
            return self._channel.receive()
        except ChannelClosedError:
            return None

    def listen(self, hear: Callable[[object], None], ended: Callable[[int | None], None]) -> None:
        """Hear it in a thread until it ends."""

        def work() -> None:
            try:
                while True:
                    hear(self._channel.receive())
            except ChannelClosedError:
                pass
            ended(self._wait())

        threading.Thread(target=work, name="from the rig's process", daemon=True).start()

    def close(self) -> int | None:
        """Let it end: its input ends. Return its code; None if it does not end in time."""
        self._channel.close()
        return self._wait()

    def _wait(self) -> int | None:
        """Return the code of a child that ends, and let go of its pipes."""
        try:
            code = self._child.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            return None
        self._channel.close()
        if self._child.stdout is not None:
            self._child.stdout.close()
        return code
