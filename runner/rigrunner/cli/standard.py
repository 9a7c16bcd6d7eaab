"""The three standard streams, which a scheduler or a shell may have closed."""

from __future__ import annotations

import os
import sys

_NAMES = {0: "stdin", 1: "stdout", 2: "stderr"}


def open_standard_streams() -> None:
    """Connect closed standard streams to the null device.

    Otherwise the next opened file would get the stream's number, and messages would be written into
    it, for example into a journal.
    """
    for number, name in _NAMES.items():
        if not _is_open(number):
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
        if getattr(sys, name) is None:
            mode = "w" if number else "r"
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: PTH123, SIM115  (a stream for as long as the program lasts)


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True
