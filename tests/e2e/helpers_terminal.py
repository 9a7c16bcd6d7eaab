"""The command line in a process of its own, at a pipe or at a pseudo-terminal."""

from __future__ import annotations

import os
import select
import subprocess
import sys
import time
from dataclasses import dataclass, field
from typing import Self

PROGRAM = (sys.executable, "-m", "rigrunner")
_ENDS_S = 200.0


@dataclass
class Terminal:
    """A process that has a pseudo-terminal as its console."""

    arguments: tuple[str, ...]
    cwd: str
    program: tuple[str, ...] = PROGRAM
    seen: str = ""
    passed: str = ""
    """The output before the text last waited for."""
    process: subprocess.Popen[bytes] = field(init=False)
    master: int = field(init=False)

    def __enter__(self) -> Self:
        import pty  # noqa: PLC0415  (there is none on Windows)

        self.master, slave = pty.openpty()
        self.process = subprocess.Popen(
            [*self.program, *self.arguments],
            cwd=self.cwd,
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
            preexec_fn=_take_console,  # noqa: PLW1509  (no thread is begun before)
            env={**os.environ, "TERM": "xterm", "COLUMNS": "160"},
        )
        os.close(slave)
        return self

    def __exit__(self, *_: object) -> None:
        self.hang_up()
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()

    def wait_for(self, text: str) -> None:
        """Read until the text appears after the last wait."""
        end_s = time.monotonic() + _ENDS_S
        while text not in self.seen:
            assert time.monotonic() < end_s, f"'{text}' never came; seen: {self.seen}"
            if select.select([self.master], [], [], 0.2)[0]:
                self.seen += os.read(self.master, 65536).decode(errors="replace")
        self.passed, _, self.seen = self.seen.partition(text)

    def type(self, text: str) -> None:
        os.write(self.master, text.encode())

    def press_ctrl_c(self) -> None:
        self.type("\x03")

    def press_ctrl_z(self) -> None:
        self.type("\x1a")

    def hang_up(self) -> None:
        """Close the terminal, as a window is closed."""
        if self.master >= 0:
            os.close(self.master)
            self.master = -1

    def ends_with(self) -> int:
        """Return the exit code, after reading the remaining output."""
        end_s = time.monotonic() + _ENDS_S
        while self.process.poll() is None and time.monotonic() < end_s:
            if self.master >= 0 and select.select([self.master], [], [], 0.1)[0]:
                self._read()
            time.sleep(0.02)
        return self.process.wait(timeout=1)

    def _read(self) -> None:
        try:
            self.seen += os.read(self.master, 65536).decode(errors="replace")
        except OSError:  # the other end is closed
            time.sleep(0.1)


def _take_console() -> None:
    import fcntl  # noqa: PLC0415  (there is none on Windows)
    import termios  # noqa: PLC0415

    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
