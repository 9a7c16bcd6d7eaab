"""Wait for a line from the keyboard, so that the caller can monitor the rig meanwhile."""

from __future__ import annotations

import importlib
import select
import sys
import time

_LOOK_EVERY_S = 0.05


def wait_for_line(within_s: float) -> bool:
    """Wait a moment for an answer; return True at once without a terminal.

    On Windows, whose `select` cannot wait for a console, a pressed key counts as a line.
    """
    if not sys.stdin.isatty():
        return True
    if sys.platform == "win32":
        console = importlib.import_module("msvcrt")
        end_s = time.monotonic() + within_s
        while not console.kbhit():
            if time.monotonic() >= end_s:
                return False
            time.sleep(_LOOK_EVERY_S)
        return True
    return bool(select.select([sys.stdin], [], [], within_s)[0])
