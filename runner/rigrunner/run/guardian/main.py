"""The program of the guardian; until it has to act it imports only the standard library.

The first line of its stdin is JSON with what it guards. Each further line is a beat: the number of
seconds until the next one is overdue. 'end' means that the rig was released. The end of stdin
without it, or of the owner's process, is the death of the owner.
"""

from __future__ import annotations

import json
import os
import select
import signal
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from rigrunner.ending import ENDING, SUSPENDING
from rigrunner.run.guardian.saying import say

TICK_S = 1.0
"""Interval of its own checks; time is counted in ticks, each of which counts as two at most.

So neither a suspended computer nor a stopped guardian looks like silence.
"""
GRACE_S = 10.0
"""Time for a hanging process to show progress once it was asked to end."""
DEATH_S = 60.0
"""Time for a process to be gone after SIGKILL: its driver may be in the kernel."""
LAST_WORDS_S = 0.2
"""Time to read the pipe of a dead owner, which another process may have inherited."""
IGNORED = (signal.SIGINT, *ENDING, *SUSPENDING)
"""Signals that do not end it."""
_DEAD, _CLOSED = "dead", "closed"


def main() -> int:
    """Guard a rig until its owner releases it, dies or hangs; return the exit code."""
    for number in IGNORED:
        with suppress(OSError, ValueError):
            signal.signal(number, signal.SIG_IGN)  # it ends with its owner, by no other word
    if hasattr(signal, "pthread_sigmask"):  # its owner blocked them until here
        signal.pthread_sigmask(signal.SIG_UNBLOCK, IGNORED)
    news: SimpleQueue[str] = SimpleQueue()
    task = json.loads(sys.stdin.readline() or "{}")
    if not task:  # its owner died before it had said what to guard
        return 0
    threading.Thread(target=_hear, args=(news,), daemon=True).start()
    owner = Owner(task["process"])
    threading.Thread(target=_watch_death, args=(owner, news), daemon=True).start()
    reason = _guard(task, owner, news)
    if reason:
        from rigrunner.run.guardian.acting import act  # noqa: PLC0415  (late: see above)

        act(task, reason)
    return 0


class Owner:
    """The process that has the rig: whether it lives, and ways to end it."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self.handle = -1
        """Signals its death at once; -1 if the system has no such handle."""
        if hasattr(os, "pidfd_open"):
            with suppress(OSError):  # an old kernel, or the owner is dead already
                self.handle = os.pidfd_open(pid)

    @property
    def is_dead(self) -> bool:
        """Whether it has ended: an orphan has another parent. On Windows only the pipe tells."""
        return os.name != "nt" and os.getppid() != self.pid

    @property
    def is_traced(self) -> bool:
        """Whether a debugger such as gdb is attached; known on Linux only."""
        try:
            text = Path(f"/proc/{self.pid}/status").read_text(encoding="utf-8", errors="replace")
        except OSError:
            return False
        found = [line.split()[1] for line in text.splitlines() if line.startswith("TracerPid:")]
        # "0": it is not traced.
        return found not in ([], ["0"])

    def send(self, name: str) -> None:
        """Send it a signal, if the system has that one and the process exists."""
        number = getattr(signal, name, None)
        if number is None or self.is_dead:
            return
        with suppress(OSError):
            if self.handle >= 0 and hasattr(signal, "pidfd_send_signal"):
                signal.pidfd_send_signal(self.handle, number)
            else:
                os.kill(self.pid, number)


def _hear(news: SimpleQueue[str]) -> None:
    for line in sys.stdin:
        news.put(line.strip())
    news.put(_CLOSED)


def _watch_death(owner: Owner, news: SimpleQueue[str]) -> None:
    if owner.handle >= 0:
        select.select([owner.handle], [], [])
        news.put(_DEAD)


def _guard(task: dict[str, Any], owner: Owner, news: SimpleQueue[str]) -> str:
    """Return why to make the rig safe; '' once it was released."""
    patience = _Patience(task, owner)
    is_deaf = not task["hangs"]
    while True:
        try:
            told = news.get(timeout=TICK_S)
        except Empty:
            told = ""
        patience.tick()
        if told == "end":
            return ""
        if told == _CLOSED and not owner.is_dead:
            is_deaf = not _dies_within(owner, TICK_S)  # somebody closed the pipe: no beats then
        if told == _DEAD or owner.is_dead or (told == _CLOSED and not is_deaf):
            if _was_given_back(news):
                return ""
            how = "hung, and was ended" if patience.is_asked else "died"
            return f"the process of {task['what']} ({owner.pid}) {how}"
        if told and told != _CLOSED:
            patience.beat(float(told))
        # What is not read yet may be the beat that is overdue.
        if patience.is_over and not is_deaf and news.empty():
            patience.end()


def _was_given_back(news: SimpleQueue[str]) -> bool:
    """Return whether 'end' is among the unread messages of a dead owner."""
    with suppress(Empty):
        while (told := news.get(timeout=LAST_WORDS_S)) != _CLOSED:
            if told == "end":
                return True
    return False


class _Patience:
    """Time without a beat of the owner, in ticks of the guardian, and the consequences."""

    def __init__(self, task: dict[str, Any], owner: Owner) -> None:
        self._task = task
        self._owner = owner
        self._limit_s = float(task["limit_s"])
        self._looked_s = time.monotonic()
        self._silent_s = 0.0
        self.is_asked = False
        """Whether the owner was asked to end."""

    def tick(self) -> None:
        """Count a tick."""
        now_s = time.monotonic()
        self._silent_s += min(now_s - self._looked_s, 2 * TICK_S)
        self._looked_s = now_s
        if self._silent_s > 2 * TICK_S and self._owner.is_traced:
            self._silent_s = 0.0  # a process that its debugger lets go has all of its time again

    def beat(self, limit_s: float) -> None:
        """Note a beat, with the time until the next one is overdue."""
        self._limit_s, self._silent_s = limit_s, 0.0

    @property
    def is_over(self) -> bool:
        """Whether the owner's beat is overdue."""
        return self._silent_s > self._limit_s

    def end(self) -> None:
        """End an owner that hangs with its rig energised: it is asked first, then killed."""
        process = f"the process of {self._task['what']} ({self._owner.pid})"
        if self._owner.is_traced or not _is_energised(self._task):
            self.beat(float(self._task["limit_s"]))
        elif not self.is_asked:
            silent = f"has shown no progress for {self._silent_s:.0f} s"
            say(f"{process} {silent}; it is asked to end (SIGTERM)")
            self.is_asked = True
            self._owner.send("SIGTERM")
            self._owner.send("SIGCONT")  # one that was stopped could not hear it
            self.beat(GRACE_S)
        else:
            say(f"{process} does not end: it is killed")
            self._owner.send("SIGKILL" if hasattr(signal, "SIGKILL") else "SIGTERM")
            if not _dies_within(self._owner, DEATH_S):
                say(
                    "it cannot be killed, and keeps its devices:"
                    " go to the rig and switch it off by hand"
                )
            self.beat(DEATH_S)


def _dies_within(owner: Owner, seconds: float) -> bool:
    end_s = time.monotonic() + seconds
    while not owner.is_dead:
        if time.monotonic() >= end_s:
            return os.name == "nt"  # where only the end of the pipe tells
        time.sleep(0.02)
    return True


def _is_energised(task: dict[str, Any]) -> bool:
    from rigrunner.rig_state import read_marker_of_held  # noqa: PLC0415  (late: see above)

    marker = read_marker_of_held(task["station"], Path(task["locks"][0]))
    return marker is not None and not marker.safe_by


if __name__ == "__main__":
    code = main()
    sys.stderr.flush()
    os._exit(code)  # a thread of a driver that hangs must not keep it, and the locks of the rig
