"""Tasks that worker processes import."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True)
class Squares:
    """Squares numbers, leaves a mark of each attempt in a folder, and fails for the given ones."""

    folder: Path
    refuses: tuple[int, ...] = ()
    breaks: tuple[int, ...] = ()
    dies: tuple[int, ...] = ()
    dies_once: tuple[int, ...] = ()

    def __call__(self, number: int) -> int:
        attempts = len(list(self.folder.glob(f"{number}-*")))
        (self.folder / f"{number}-{os.getpid()}-{time.monotonic_ns()}").touch()
        if number in self.refuses:
            raise DataError(f"{number} is refused", hint="take another")
        if number in self.breaks:
            raise ZeroDivisionError(number)
        if number in self.dies or (number in self.dies_once and not attempts):
            os.kill(os.getpid(), signal.SIGKILL)
        return number**2

    def attempts(self) -> list[int]:
        """Return the numbers that were begun, once for each attempt."""
        return sorted(int(mark.name.split("-")[0]) for mark in self.folder.iterdir())


def end_by(number):
    os.kill(os.getpid(), number)


def hang(seconds):
    time.sleep(seconds)


def environment(name):
    return os.environ.get(name)
