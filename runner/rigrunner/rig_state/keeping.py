"""Keeps the files of a rig in use: somebody, or a cleaner of old files, may remove them.

Cleaners remove files that were not changed for a time, as systemd does in /var/tmp after 30 days. A
lock on a file without a name does not exclude a process that makes a new one.
"""

from __future__ import annotations

import os
import threading
import time
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceError
from rigrunner.rig_state.folder import shared_folder
from rigrunner.rig_state.locks import Busy, Holder, hold, is_removed, touch

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.rig_state.marks import RigMarks

TICK_S = 1.0
"""Interval at which the files are checked: the gap for another process."""
TOUCH_S = 3600.0
"""Interval at which they are marked as used."""


@contextmanager
def keeping(marks: RigMarks, report: Callable[[str], None]) -> Iterator[None]:
    """Keep the files of a held rig: they do not grow old, and are recreated if removed.

    `report` is called, from a thread, with what was removed and what followed. Does nothing on
    Windows, where an open file cannot be removed.
    """
    if os.name == "nt":
        yield
        return
    ended = threading.Event()
    thread = threading.Thread(
        target=_keep, args=(marks, report, ended), name="lock files", daemon=True
    )
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def _keep(marks: RigMarks, report: Callable[[str], None], ended: threading.Event) -> None:
    owner, touched_s, last_text = marks.owner, -TOUCH_S, ""
    holder = Holder(owner.station, owner.procedure, owner.process, owner.since)
    with ExitStack() as stack:
        while not ended.wait(TICK_S):
            text = _recreate_removed(marks, holder, stack)
            if text and text != last_text:
                report(text)
            last_text = text
            if time.monotonic() - touched_s >= TOUCH_S:
                touched_s = time.monotonic()
                for lock, descriptor in marks.locks.items():
                    touch(lock, descriptor)
                marks.touch()


def _recreate_removed(marks: RigMarks, holder: Holder, stack: ExitStack) -> str:
    """Recreate removed files, and return that as text; '' for nothing.

    The marker comes first: without a lock file the guardian takes the rig for energised.
    """
    removed = [lock for lock, descriptor in marks.locks.items() if is_removed(descriptor)]
    names = ", ".join(map(str, removed)) or "the marker of the energised rig"
    try:
        marks.renew()
        for lock in removed:
            shared_folder()
            (marks.locks[lock],) = stack.enter_context(hold([lock], holder))
    except Busy as busy:
        who = f" ({busy.holder.procedure}, process {busy.holder.process})" if busy.holder else ""
        problem = f"another process{who} has taken the rig: two programs may drive the rig"
        return f"{names} was removed during the run, and {problem}"
    except (DeviceError, OSError) as error:
        return f"{names} was removed during the run and cannot be made anew: {error}"
    return f"{names} was removed during the run and made anew" if removed else ""
