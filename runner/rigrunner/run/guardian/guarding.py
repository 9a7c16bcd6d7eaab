"""Starts the guardian of a rig, reports the progress of the run to it, and ends it."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from rigrunner.engine import Interference
from rigrunner.rig import Pulse
from rigrunner.rig_state.keeping import keeping
from rigrunner.run.guardian.guarded import WITHOUT, guardian_text, not_reopenable
from rigrunner.run.guardian.main import IGNORED, TICK_S
from rigrunner.run.guardian.saying import say

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    from rigrunner.api.devices import Patience
    from rigrunner.registry import Registry
    from rigrunner.rig.messages import DeviceMessages
    from rigrunner.rig_state import RigMarks
    from rigrunner.station import LoadedStation

MODULE = "rigrunner.run.guardian.main"
LEAST_S = 10.0
"""Least time without progress that is tolerated: a disk may delay a run for seconds."""
PATIENCES = 3.0
"""The same, as a multiple of the time limit of a device of the station."""
MOST_STARTS = 4
"""Number of guardians started for a rig: a killed one is replaced."""
_DEBUGGERS = {
    *("bdb", "pdb", "code", "ipdb", "pudb", "rpdb", "remote_pdb", "web_pdb", "IPython"),
    *("debugpy", "pydevd", "_pydevd_bundle", "_pydevd_frame_eval"),
}
"""Top packages of debuggers and consoles, whose code waits in the thread that they hold."""
END_S = 5.0
NAME = "guardian"
"""Source of the message about a lost guardian."""


class Guardian:
    """The guardian of one rig, from the side of the process that drives the rig."""

    def __init__(
        self, task: Mapping[str, Any], marks: RigMarks, limit_s: float, messages: DeviceMessages
    ) -> None:
        self.pulse = Pulse(limit_s, self._beat)
        self._messages = messages
        self._task = dict(task)
        self._marks = marks
        self._limit_s = limit_s
        self._child: subprocess.Popen[bytes] | None = None
        self._starts = 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._work, name="guardian", daemon=True)
        # A debugger that suspends all threads leaves this one running: a breakpoint is no hang.
        self._thread.pydev_do_not_trace = True  # type: ignore[attr-defined]  # known to pydevd
        self._thread.is_pydev_daemon_thread = True  # type: ignore[attr-defined]  # known to pydevd

    def start(self) -> None:
        """Start it; if that fails, the run continues and records the failure."""
        self._begin()
        if unreachable := self._task["unreachable"]:
            names = ", ".join(unreachable)
            self._marks.describe(unguarded=f"no second process can open {names}")
        if self._child is not None:
            self._marks.describe(guardian="a second process")
        self._thread.start()

    def end(self) -> None:
        """End it: the rig was released."""
        # First of all: the thread would replace a guardian that ends.
        self._ended.set()
        self._thread.join(END_S)
        child = self._child
        if child is None or child.stdin is None:
            return
        with suppress(OSError):
            os.write(child.stdin.fileno(), b"end\n")
        with suppress(OSError):
            child.stdin.close()
        try:
            child.wait(END_S)
        except subprocess.TimeoutExpired:  # it was stopped: it has nothing to guard any more
            child.kill()
            child.wait()

    def _begin(self) -> None:
        self._starts += 1
        descriptors = list(self._marks.locks.values()) if os.name != "nt" else []
        if -1 in descriptors:
            descriptors = []  # it locks them again, once they are free
        try:
            with _blocked(IGNORED):  # a new process inherits that, until it ignores them itself
                child = subprocess.Popen(  # noqa: S603  (our own interpreter and module)
                    [sys.executable, "-P", "-m", MODULE],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    pass_fds=descriptors,
                    start_new_session=True,  # neither Ctrl-C nor a closed terminal is its
                    creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
                )
        except OSError as error:
            self._lose(f"no guardian could be started: {error}")
            self._child = None
            return
        assert child.stdin is not None  # noqa: S101  (it is a pipe)
        task = {**self._task, "handed": descriptors}
        with suppress(OSError):
            os.write(child.stdin.fileno(), json.dumps(task).encode() + b"\n")
        if os.name != "nt":
            # A guardian that was stopped does not read: a beat must not block the run.
            os.set_blocking(child.stdin.fileno(), False)
        self._child = child

    def _work(self) -> None:
        ticked_s = time.monotonic()
        while not self._ended.wait(TICK_S):
            now_s = time.monotonic()
            # As in the guardian: a suspended computer has not been silent.
            self.pulse.tick(min(now_s - ticked_s, 2 * TICK_S))
            ticked_s = now_s
            left_s = self.pulse.left_s()
            if left_s > 0 or debugger_at(threading.main_thread()):
                self._beat(self._limit_s if math.isinf(left_s) else max(left_s, self._limit_s))
            if self._child is not None and (code := self._child.poll()) is not None:
                self._replace(self._child.pid, code)

    def _beat(self, allowed_s: float) -> None:
        child = self._child
        if child is not None and child.stdin is not None:
            with suppress(OSError, ValueError):  # it is gone, or stopped: the thread checks it
                os.write(child.stdin.fileno(), f"{allowed_s:.3f}\n".encode())

    def _replace(self, pid: int, code: int) -> None:
        if self._child is not None and self._child.stdin is not None:
            with suppress(OSError):
                self._child.stdin.close()
        self._child = None
        lost = f"the guardian (process {pid}) ended with code {code}"
        if self._starts >= MOST_STARTS:
            self._lose(f"{lost}; no other one is started: nothing makes the rig safe if this dies")
            return
        self._begin()
        if self._child is not None:
            self._lose(f"{lost}; process {self._child.pid} guards the rig now")

    def _lose(self, text: str) -> None:
        """Record that the guardian was lost, as a message of a device."""
        self._messages.take(NAME, "warning", text)
        say(text)


@contextmanager
def _blocked(numbers: Collection[int]) -> Iterator[None]:
    """Block these signals in this thread; those that arrive are handled afterwards."""
    if not hasattr(signal, "pthread_sigmask"):  # not on Windows
        yield
        return
    former = signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, former)


@contextmanager
def guarding(
    station: LoadedStation,
    registry: Registry,
    marks: RigMarks | None,
    patience: Patience,
    what: str,
    *,
    messages: DeviceMessages,
    roles: Collection[str] | None = None,
) -> Iterator[Guardian | None]:
    """Start a guardian for a rig that this process holds; yield it, or None for none.

    There is none for simulators, for replays, and if the station does not want one. `roles` are
    those in use, by default all; `messages` take a report of a lost guardian. With endless patience
    it detects only the death of this process, not a hang. Meanwhile the files of the rig's locks
    and its marker are kept.
    """
    if marks is None:
        yield None
        return

    def report(text: str) -> None:
        messages.take("lock files", "warning", text)
        say(text)

    with keeping(marks, report):
        if not station.model.safety.guardian:
            say(f"{WITHOUT}: nothing makes the rig safe if this process dies")
            yield None
            return
        used = [role for role in marks.roles if roles is None or role in roles]
        unreachable = not_reopenable(station, registry, used)
        limit_s = max(LEAST_S, PATIENCES * patience.answer_s)
        endless = not math.isfinite(limit_s)
        task = {
            "process": os.getpid(),
            "what": what,
            "station": station.model.id,
            "station_file": marks.owner.station_file,
            "station_text": station.text,
            "roles": sorted(set(used) - set(unreachable)),
            "unreachable": unreachable,
            "locks": [str(path) for path in marks.locks],
            "limit_s": LEAST_S if endless else limit_s,
            "hangs": not endless,
        }
        guardian = Guardian(task, marks, LEAST_S if endless else limit_s, messages)
        guardian.start()
        try:
            yield guardian
        finally:
            guardian.end()


def unguarded(
    station: LoadedStation, registry: Registry, real: Collection[str]
) -> list[Interference]:
    """Return the remark of a run whose guardian does not cover all real devices."""
    if real and (not station.model.safety.guardian or not_reopenable(station, registry, real)):
        text = guardian_text(station, registry, real)
        return [Interference("guardian", by="station", subject=text)]
    return []


def debugger_at(thread: threading.Thread) -> bool:
    """Return whether code of a debugger is running in a thread."""
    frame = sys._current_frames().get(thread.ident or 0)  # noqa: SLF001  (public in all but name)
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).partition(".")[0] in _DEBUGGERS:
            return True
        frame = frame.f_back
    return False
