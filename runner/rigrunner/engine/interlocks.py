"""Interlocks of a run: the last reading of each channel, and the consequence."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.cleanup import error_text
from rigrunner.api.errors import AbortedError
from rigrunner.api.events import InterlockCleared, InterlockTripped
from rigrunner.api.member import Member
from rigrunner.engine.pausing import PauseRequestedError
from rigrunner.engine.watching import Watch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.data import Block
    from rigrunner.bus import Emit
    from rigrunner.plan.actions import Interlock
    from rigrunner.rig import Rig

_ROUNDING_S = 1e-9
_CLOCKS_DISAGREE = 1e-3
"""How far the clock of a stream may be off, relative to its time."""
_BY_SEVERITY = ("make_safe", "abort", "pause")


class InterlockError(AbortedError):
    """An interlock ends the run; `makes_safe`: the rig is made safe before the teardown."""

    def __init__(self, text: str, by: str, *, makes_safe: bool) -> None:
        super().__init__(text, by=by)
        self.makes_safe = makes_safe


class Guard:
    """Monitors the channels of all interlocks between blocks, and allows or forbids set-points."""

    def __init__(self, interlocks: Sequence[Interlock], rig: Rig, emit: Emit) -> None:
        self._rig = rig
        self._emit = emit
        now_s = rig.clock.monotonic_s()
        self._watches = [Watch(interlock, now_s) for interlock in interlocks]
        self._began_s: dict[str, float] = {}
        """By role, when its latest stream began, by the clock of the rig."""
        self.watching = bool(self._watches)
        """Whether there are interlocks; without any, steps need not call."""

    @property
    def tripped(self) -> list[Watch]:
        """The interlocks that are tripped and not overridden."""
        return [watch for watch in self._watches if watch.tripped and not watch.overridden]

    def pausing(self) -> str:
        """Return what prevents a paused run from continuing, as text."""
        acting = [
            watch
            for watch in self.tripped
            # One that forbids a drive matters only if resuming would move that drive.
            if watch.interlock.does == "pause"
            or any(self._rig.resume_leads_away(d.role, d.name) for d in watch.interlock.forbids)
        ]
        return "; ".join(watch.text for watch in acting)

    def may_be_overridden(self) -> bool:
        """Return whether interlocks are tripped and a person may override all of them."""
        return bool(self.tripped) and all(watch.interlock.overridable for watch in self.tripped)

    def override(self) -> None:
        """Override the tripped interlocks until each has cleared."""
        for watch in self.tripped:
            watch.overridden = True

    def feed(self, role: str, block: Block) -> None:
        """Check the samples of a stream, whose channels are named without the role."""
        watched = [
            watch
            for watch in self._watches
            if (member := watch.interlock.member).role == role and member.name in block.channels
        ]
        if not watched or not block.samples:
            return
        now_s, end = self._rig.clock.monotonic_s(), block.first_sample + block.samples
        began_s = now_s - end / block.rate_hz
        if block.first_sample and role in self._began_s:
            # Blocks come late, or two at once; the least late one shows when the stream began.
            before_s = self._began_s[role]
            latest_s = before_s + _CLOCKS_DISAGREE * block.samples / block.rate_hz
            for watch in watched if began_s < before_s else ():
                watch.shift(before_s, before_s - began_s)
            began_s = min(began_s, latest_s)
        self._began_s[role] = began_s
        times_s = began_s + np.arange(block.first_sample + 1, end + 1) / block.rate_hz
        for watch in watched:
            watch.take(times_s, np.asarray(block.channels[watch.interlock.member.name]), now_s)

    def look(self, *, read_all: bool = False) -> None:
        """Read the channels that are due, or all; record what tripped or cleared."""
        for watch in self._watches:
            now_s = self._rig.clock.monotonic_s()
            if read_all or now_s - watch.looked_s >= watch.interlock.every_s - _ROUNDING_S:
                self._read(watch)
        for watch in self._watches:
            self._emit_changes(watch)

    def check(self, *, read_all: bool = False) -> None:
        """Look, then raise InterlockError or PauseRequestedError for what is tripped."""
        self.look(read_all=read_all)
        acting = [watch for watch in self.tripped if watch.interlock.does != "forbid"]
        # Only the first is raised: one that pauses must not hide one that makes safe.
        for watch in sorted(acting, key=lambda watch: _BY_SEVERITY.index(watch.interlock.does)):
            if watch.interlock.does == "pause":
                raise PauseRequestedError(watch.text, by=f"interlock {watch.interlock.name}")
            raise _error(watch.interlock, watch.text)

    def allow(self, role: str, drive: str, value: float) -> None:
        """Raise InterlockError if a set-point leaves the safe value while that is forbidden."""
        member = Member(role, drive)
        blocking = [watch for watch in self.tripped if member in watch.interlock.forbids]
        for watch in blocking:
            # Towards the safe value is always allowed: a device that is too hot may be unloaded.
            if self._rig.leads_away(role, drive, value):
                text = f"{member} may not be set to {value:g}: {watch.text}"
                raise _error(watch.interlock, text)

    def _read(self, watch: Watch) -> None:
        member = watch.interlock.member
        try:
            value = self._rig.read(member.role, (member.name,))[member]
        except Exception as error:  # noqa: BLE001  (unread, it may be out of range)
            watch.miss(self._rig.clock.monotonic_s(), error_text(error))
            return
        now_s = self._rig.clock.monotonic_s()
        watch.take(np.array([now_s]), np.array([value]), now_s)

    def _emit_changes(self, watch: Watch) -> None:
        changes, watch.changes = watch.changes, []
        for change in changes:
            name, source = watch.interlock.name, f"interlock {watch.interlock.name}"
            if change == "tripped":
                self._emit(
                    InterlockTripped,
                    source=source,
                    interlock=name,
                    text=watch.text,
                    does=watch.interlock.does,
                    latency_s=watch.latency_s,
                )
            else:
                self._emit(InterlockCleared, step=source, interlock=name, text=watch.text)


def _error(interlock: Interlock, text: str) -> InterlockError:
    makes_safe = interlock.does == "make_safe"
    return InterlockError(text, f"interlock {interlock.name}", makes_safe=makes_safe)
