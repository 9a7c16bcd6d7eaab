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
            signal.signal(number, signal.SIG_IGN)  # it ends only with its owner
    if hasattr(signal, "pthread_sigmask"):  # its owner blocked them until here
        signal.pthread_sigmask(signal.SIG_UNBLOCK, IGNORED)
    messages: SimpleQueue[str] = SimpleQueue()
    task = json.loads(sys.stdin.readline() or "{}")
    if not task:  # its owner died before it sent the task
        return 0
    threading.Thread(target=_read_stdin, args=(messages,), daemon=True).start()
    owner = Owner(task["process"])
    threading.Thread(target=_watch_death, args=(owner, messages), daemon=True).start()
    reason = _guard(task, owner, messages)
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
        """Whether it has ended: an orphan has another parent. On Windows only the pipe shows it."""
        return os.name != "nt" and os.getppid() != self.pid

    @property
    def is_traced(self) -> bool:
        """Whether a debugger such as gdb is attached; known on Linux only."""
        try:
            text = Path(f"/proc/{self.pid}/status").read_text(encoding="utf-8", errors="replace")
        except OSError:
            return False
        tracers = [line.split()[1] for line in text.splitlines() if line.startswith("TracerPid:")]
        # "0": it is not traced.
        return tracers not in ([], ["0"])

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


def _read_stdin(messages: SimpleQueue[str]) -> None:
    for line in sys.stdin:
        messages.put(line.strip())
    messages.put(_CLOSED)


def _watch_death(owner: Owner, messages: SimpleQueue[str]) -> None:
    if owner.handle >= 0:
        select.select([owner.handle], [], [])
        messages.put(_DEAD)


def _guard(task: dict[str, Any], owner: Owner, messages: SimpleQueue[str]) -> str:
    """Return why to make the rig safe; '' once it was released."""
    patience = _Patience(task, owner)
    ignores_silence = not task["hangs"]
    while True:
        try:
            message = messages.get(timeout=TICK_S)
        except Empty:
            message = ""
        patience.tick()
        if message == "end":
            return ""
        if message == _CLOSED and not owner.is_dead:
            # Somebody closed the pipe: there are no beats then.
            ignores_silence = not _dies_within(owner, TICK_S)
        if message == _DEAD or owner.is_dead or (message == _CLOSED and not ignores_silence):
            if _was_released(messages):
                return ""
            how = "hung, and was ended" if patience.was_asked else "died"
            return f"the process of {task['what']} ({owner.pid}) {how}"
        if message and message != _CLOSED:
            patience.beat(float(message))
        # An unread message may be the overdue beat.
        if patience.is_over and not ignores_silence and messages.empty():
            patience.end()


def _was_released(messages: SimpleQueue[str]) -> bool:
    """Return whether 'end' is among the unread messages of a dead owner."""
    with suppress(Empty):
        while (message := messages.get(timeout=LAST_WORDS_S)) != _CLOSED:
            if message == "end":
                return True
    return False


class _Patience:
    """Time without a beat of the owner, in ticks of the guardian, and the consequences."""

    def __init__(self, task: dict[str, Any], owner: Owner) -> None:
        self._task = task
        self._owner = owner
        self._limit_s = float(task["limit_s"])
        self._ticked_s = time.monotonic()
        self._silent_s = 0.0
        self.was_asked = False
        """Whether the owner was asked to end."""

    def tick(self) -> None:
        """Count a tick."""
        now_s = time.monotonic()
        self._silent_s += min(now_s - self._ticked_s, 2 * TICK_S)
        self._ticked_s = now_s
        if self._silent_s > 2 * TICK_S and self._owner.is_traced:
            self._silent_s = 0.0  # a process that its debugger releases has its full time again

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
        elif not self.was_asked:
            silent = f"has shown no progress for {self._silent_s:.0f} s"
            say(f"{process} {silent}; it is asked to end (SIGTERM)")
            self.was_asked = True
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
            return os.name == "nt"  # where only the end of the pipe shows it
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
