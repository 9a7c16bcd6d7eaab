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
"""Interval at which it is looked whether the files are there: the gap for another process."""
TOUCH_S = 3600.0
"""Interval at which they are marked as used."""


@contextmanager
def keeping(marks: RigMarks, tell: Callable[[str], None]) -> Iterator[None]:
    """Keep the files of a held rig: they do not grow old, and are made anew where removed.

    `tell` is called, from a thread, with what was removed and what followed. Does nothing on
    Windows, where an open file cannot be removed.
    """
    if os.name == "nt":
        yield
        return
    ended = threading.Event()
    thread = threading.Thread(
        target=_keep, args=(marks, tell, ended), name="lock files", daemon=True
    )
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def _keep(marks: RigMarks, tell: Callable[[str], None], ended: threading.Event) -> None:
    owner, touched_s, known = marks.owner, -TOUCH_S, ""
    holder = Holder(owner.station, owner.procedure, owner.process, owner.since)
    with ExitStack() as held:
        while not ended.wait(TICK_S):
            found = _made_anew(marks, holder, held)
            if found and found != known:
                tell(found)
            known = found
            if time.monotonic() - touched_s >= TOUCH_S:
                touched_s = time.monotonic()
                for lock, descriptor in marks.locks.items():
                    touch(lock, descriptor)
                marks.touch()


def _made_anew(marks: RigMarks, holder: Holder, held: ExitStack) -> str:
    """Make anew what was removed, and return that as text; '' for nothing.

    The marker comes first: without a lock file the guardian takes the rig for energised.
    """
    removed = [lock for lock, descriptor in marks.locks.items() if is_removed(descriptor)]
    names = ", ".join(map(str, removed)) or "the marker of the energised rig"
    try:
        marks.renew()
        for lock in removed:
            shared_folder()
            (marks.locks[lock],) = held.enter_context(hold([lock], holder))
    except Busy as busy:
        who = f" ({busy.holder.procedure}, process {busy.holder.process})" if busy.holder else ""
        taken = f"another process{who} has taken the rig: two programs may drive the rig"
        return f"{names} was removed during the run, and {taken}"
    except (DeviceError, OSError) as error:
        return f"{names} was removed during the run and cannot be made anew: {error}"
    return f"{names} was removed during the run and made anew" if removed else ""
