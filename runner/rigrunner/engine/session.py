"""What steps work with."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError, DeviceTimeoutError
from rigrunner.api.events import Alarm, Intervention, Note
from rigrunner.engine.pausing import PauseWantedError, Reasoned, Telling

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api.devices import StopToken
    from rigrunner.bus import Emit
    from rigrunner.engine.answers import AnswerSource
    from rigrunner.engine.drive_watch import DriveWatch
    from rigrunner.engine.interlocks import Guard
    from rigrunner.engine.pausing import Pauses
    from rigrunner.rig import Rig


@dataclass(frozen=True)
class Session:
    """The rig, where events go, who answers, and whether to go on."""

    rig: Rig
    emit: Emit
    answers: AnswerSource
    stop: StopToken
    guard: Guard
    pauses: Pauses | None = None
    """Who may pause the run; None where nobody is there to go on."""
    timeout_s: float | None = None
    """How long the present step may take."""
    began_s: float = 0.0
    """When the present step began, by the rig's clock."""
    drives: DriveWatch | None = None
    """Watches the drives that were set; None where nobody does."""
    reads: bool = False
    """Whether the present step reads something: then its drives are watched."""
    is_ending: bool = False
    """Whether this is a teardown."""

    def within(self, timeout_s: float) -> Session:
        """Return the session of a step that begins now and may take that long."""
        return replace(self, timeout_s=timeout_s, began_s=self.rig.clock.monotonic_s())

    def ending(self) -> Session:
        """Return the session of a teardown: neither stopped nor paused, interlocks only told."""
        return replace(self, stop=_Never(), is_ending=True)

    def put_messages(self) -> None:
        """Put on record what the drivers have told beside their answers."""
        for each in self.rig.messages.taken():
            source = f"device {each.role}"
            if each.level == "info":
                self.emit(Note, step=source, text=each.text)
            else:
                self.emit(Alarm, source=source, text=f"{each.level}: {each.text}")

    def check(self, *, anew: bool = False) -> None:
        """Raise what keeps the step from going on; `anew`: all interlocks are read.

        AbortedError if the run is asked to stop or an interlock aborts it, PauseWantedError if it
        is to pause, DeviceTimeoutError if its time is over.
        """
        if self._telling is not None:
            self._tell(self._telling)
        if self.rig.messages:
            self.put_messages()
        if self.stop.is_set():
            raise stopped(self.stop)
        if self.is_ending:
            self.guard.look()
        else:
            if self.guard.watching:
                self.guard.check(anew=anew)
            if self.pauses is not None and (by := self.pauses.wanted()):
                raise PauseWantedError("a pause was asked for", by)
            if self.reads and self.drives is not None:
                self.drives.look()
        if self.timeout_s is not None:
            self.check_time()

    def check_drives(self) -> None:
        """Raise InterlockError for a drive that is not where it was set, in a step that reads."""
        if self.reads and self.drives is not None and not self.is_ending:
            self.drives.check()

    def checker(self) -> Callable[[], None]:
        """Return what checks anew, again and again within this step.

        Where nothing but the stop token and the drives can keep the step from going on, it looks at
        these alone.
        """
        if self.guard.watching or self.pauses is not None or self.timeout_s is not None:
            return partial(self.check, anew=True)
        stop = self.stop
        is_set = stop.is_set
        look_at_drives = self.drives.look if self.reads and self.drives is not None else None

        def look() -> None:
            if is_set():
                raise stopped(stop)
            if look_at_drives is not None:
                look_at_drives()

        return look

    def watch(self, *, anew: bool = False) -> None:
        """Raise AbortedError if the run is not to go on; what only pauses it does not matter."""
        if self._telling is not None:
            self._tell(self._telling)
        if self.stop.is_set():
            raise stopped(self.stop)
        with suppress(PauseWantedError):
            self.guard.check(anew=anew)

    @cached_property
    def _telling(self) -> Telling | None:
        """The pauses that know what else a person did; found out once, which takes its time."""
        return self.pauses if isinstance(self.pauses, Telling) else None

    def _tell(self, telling: Telling) -> None:
        """Put on record what else a person did."""
        for each in telling.told():
            self.emit(Intervention, **asdict(each))

    def set(self, role: str, drive: str, value: float) -> float:
        """Set a drive and return its read-back; raise InterlockError if that is forbidden."""
        if self.guard.watching:
            self.guard.allow(role, drive, value)
        return self.rig.set(role, drive, value, self.timeout_s, self.check)

    def setter(self, role: str, drive: str) -> Callable[[float], float]:
        """Return what sets a drive as `set` does, again and again within this step."""
        if self.guard.watching:
            return partial(self.set, role, drive)
        return self.rig.setter(role, drive, self.timeout_s, self.check)

    def check_time(self) -> None:
        """Raise DeviceTimeoutError if the step has taken longer than it may."""
        if self.timeout_s is None:
            return
        if self.rig.clock.monotonic_s() - self.began_s > self.timeout_s:
            raise DeviceTimeoutError(
                f"the step is not done within {self.timeout_s:g} s", hint="see its timeout"
            )


def stopped(stop: StopToken) -> AbortedError:
    """Return what ends a run that is asked to stop, in the token's own words if it has any."""
    return stop.reason() if isinstance(stop, Reasoned) else AbortedError("stopped on request")


class _Never:
    """The stop token of the teardown: a run that was asked to stop still ends in order."""

    def is_set(self) -> bool:
        return False
