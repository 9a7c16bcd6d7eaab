"""Whether a debugger of Python holds a thread: then a person looks at it, and it does not hang."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import threading

_MODULES = {
    *("bdb", "pdb", "code", "ipdb", "pudb", "rpdb", "remote_pdb", "web_pdb", "IPython"),
    *("debugpy", "pydevd", "_pydevd_bundle", "_pydevd_frame_eval"),
}
"""The top packages of debuggers and consoles, whose code waits in the thread that they hold."""


def debugger_at(thread: threading.Thread) -> bool:
    """Say whether the code of a debugger is at work in a thread."""
    frame = sys._current_frames().get(thread.ident or 0)  # noqa: SLF001  (public in all but name)
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).partition(".")[0] in _MODULES:
            return True
        frame = frame.f_back
    return False
