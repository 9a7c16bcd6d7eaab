"""The context that steps work with."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import ceil
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError, DataError, DeviceTimeoutError
from rigrunner.api.events import Alarm, Intervention, LimitMissed, Note
from rigrunner.api.steps import NONE
from rigrunner.engine.limits import missed_of, remarks_on
from rigrunner.engine.pausing import PauseRequestedError, Reasoned, Reporting, Showing
from rigrunner.engine.streams import checked_stream

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from rigrunner.api.data import Block
    from rigrunner.api.devices import Clock, StopToken
    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.member import Member
    from rigrunner.api.quantity import Estimate
    from rigrunner.api.readings import Reading, ReadingLimit
    from rigrunner.bus import Emit
    from rigrunner.engine.answers import AnswerSource
    from rigrunner.engine.drive_watch import DriveWatch
    from rigrunner.engine.interlocks import Guard
    from rigrunner.engine.pausing import Pauses
    from rigrunner.rig import Rig

_NAP_S = 0.1
"""Interval at which waiting checks the stop token."""
_MOST_RAMP_STEPS = 1000
"""A longer ramp has longer steps, not more of them."""


@dataclass(frozen=True)
class Session:
    """The rig, the sink of events, the source of answers, and whether to continue."""

    rig: Rig
    emit: Emit
    answers: AnswerSource
    stop: StopToken
    guard: Guard
    pauses: Pauses | None = None
    """Who can pause the run; None if unattended."""
    timeout_s: float | None = None
    """Time limit of the present step."""
    began_s: float = 0.0
    """Start of the present step, by the clock of the rig."""
    drives: DriveWatch | None = None
    """Monitors the drives that were set; None for no monitoring."""
    reads: bool = False
    """Whether the present step reads values: then its drives are monitored."""
    is_ending: bool = False
    """Whether this is a teardown."""
    inputs: dict[str, str] = field(default_factory=dict)
    """The answers so far; steps add to them."""
    results: Callable[[str], Estimate] | None = None
    """Calculates a result by name from the data so far; None if unavailable."""

    def within(self, timeout_s: float) -> Session:
        """Return the session of a step that begins now, with a time limit."""
        return replace(self, timeout_s=timeout_s, began_s=self.rig.clock.monotonic_s())

    def ending(self) -> Session:
        """Return the session of a teardown: not stopped or paused, interlocks only reported."""
        return replace(self, stop=_Never(), is_ending=True)

    @cached_property
    def reading(self) -> Session:
        """The session of a step during which drives must keep their set-points."""
        return replace(self, reads=True)

    def put_messages(self) -> None:
        """Record the log messages of the drivers."""
        for message in self.rig.messages.taken():
            source = f"device {message.role}"
            if message.level == "info":
                self.emit(Note, step=source, text=message.text)
            else:
                self.emit(Alarm, source=source, text=f"{message.level}: {message.text}")

    def check(self, *, read_all: bool = False) -> None:
        """Raise what prevents the step from continuing; with `read_all` all interlocks are read.

        AbortedError if the run has to stop or an interlock aborts it, PauseRequestedError if it
        has to pause, DeviceTimeoutError if its time is over.
        """
        if self._reporting is not None:
            self._record_actions(self._reporting)
        if self.rig.messages:
            self.put_messages()
        if self.stop.is_set():
            raise stopped(self.stop)
        if self.is_ending:
            self.guard.look()
        else:
            if self.guard.watching:
                self.guard.check(read_all=read_all)
            if self.pauses is not None and (by := self.pauses.requested_by()):
                raise PauseRequestedError("pause requested", by)
            if self.reads and self.drives is not None:
                self.drives.look()
        if self.timeout_s is not None:
            self.check_time()

    def check_drives(self) -> None:
        """Raise InterlockError for a drive that left its set-point, in a step that reads."""
        if self.reads and self.drives is not None and not self.is_ending:
            self.drives.check()

    def watch(self, *, read_all: bool = False) -> None:
        """Raise AbortedError if the run must not continue; pauses are ignored."""
        if self._reporting is not None:
            self._record_actions(self._reporting)
        if self.stop.is_set():
            raise stopped(self.stop)
        # It is paused already, or has no step left to pause.
        with suppress(PauseRequestedError):
            self.guard.check(read_all=read_all)
        self.show()

    def show(self) -> None:
        """Update the display of the channels; nothing may be streaming."""
        if self._showing is not None:
            self._showing.show(self.rig)

    @cached_property
    def _showing(self) -> Showing | None:
        return self.pauses if isinstance(self.pauses, Showing) else None

    @cached_property
    def _reporting(self) -> Reporting | None:
        """The pauses that report other actions of people; determined once, since it is slow."""
        return self.pauses if isinstance(self.pauses, Reporting) else None

    def _record_actions(self, pauses: Reporting) -> None:
        """Record other actions of people."""
        for action in pauses.new_actions():
            self.intervene(action.action, action.by, action.reason, action.subject)

    @property
    def clock(self) -> Clock:
        """The clock of the rig."""
        return self.rig.clock

    def answer(self, name: str) -> str | None:
        """Return the present answer of an input; None for none."""
        return self.inputs.get(name)

    def result(self, name: str) -> Estimate:
        """Return a result from the data so far; raise DataError for none."""
        if self.results is None:
            raise DataError(f"'{name}': no results are computed here")
        # A calculation can take long: interlocks and stop requests are served meanwhile.
        pool = ThreadPoolExecutor(1)
        try:
            computed = pool.submit(self.results, name)
            # In wall time: a simulated clock would not wait at all.
            while not wait([computed], _NAP_S).done:
                self.clock.sleep(0.0)  # progress, for the guardian
                self.check()
            return computed.result()
        finally:
            # What ended the run must not wait for the calculation.
            pool.shutdown(wait=False)

    def note(self, step: str, text: str) -> None:
        """Record a remark."""
        self.emit(Note, step=step, text=text)

    def intervene(self, action: str, by: str, reason: str = "", subject: str = "") -> None:
        """Record an action of a person."""
        self.emit(Intervention, action=action, by=by, reason=reason, subject=subject)

    def judge(
        self,
        step: str,
        limits: Sequence[ValueLimit],
        values: Mapping[str, float],
        where: Callable[[], str] | None = None,
        *,
        expected: Sequence[ReadingLimit] = (),
        readings: Mapping[str, Reading] = NONE,
    ) -> str:
        """Record values out of limits or marginal; return the former as text."""
        missed = []
        for kind, text in (*remarks_on(limits, values, where), *missed_of(expected, readings)):
            self.emit(kind, step=step, text=text)
            if kind is LimitMissed:
                missed.append(text)
        return "; ".join(missed)

    def naps(self, duration_s: float) -> Iterator[None]:
        """Yield during a duration, often enough to check the stop token."""
        clock = self.rig.clock
        until_s = clock.monotonic_s() + duration_s
        while (left_s := until_s - clock.monotonic_s()) > 0:
            self.check()
            self.show()
            yield
            clock.sleep(min(left_s, _NAP_S))

    def wait(self, duration_s: float) -> None:
        """Wait for a duration; raise what prevents the step from continuing."""
        for _ in self.naps(duration_s):
            pass

    def read(self, channels: Sequence[Member]) -> dict[str, float]:
        """Return the present value of each channel, in the given order."""
        return self.reader(channels)()

    def observe(self, readings: Sequence[Member]) -> dict[str, Reading]:
        """Return readings that are not numbers."""
        values: dict[str, Reading] = {}
        for role in dict.fromkeys([member.role for member in readings]):
            values |= self.rig.observe(role, [m.name for m in readings if m.role == role])
        return {member: values[member] for member in readings}

    def reader(self, channels: Sequence[Member]) -> Callable[[], dict[str, float]]:
        """Return a function that reads channels repeatedly, as `read` does."""
        roles = dict.fromkeys([channel.role for channel in channels])
        # One call for each device, however its channels are mixed with those of others.
        readers = [
            self.rig.reader(role, [channel.name for channel in channels if channel.role == role])
            for role in roles
        ]
        if len(readers) == 1:
            return readers[0]

        def read() -> dict[str, float]:
            values = {name: value for reader in readers for name, value in reader().items()}
            return {member: values[member] for member in channels}

        return read

    def stream(self, role: str, channels: Sequence[str], duration_s: float) -> Iterator[Block]:
        """Yield the checked blocks of a device, with channels named 'role.channel'."""
        return checked_stream(self, role, channels, duration_s)

    def stream_means(
        self, role: str, channels: Sequence[str], duration_s: float
    ) -> dict[str, float]:
        """Return the mean of each channel over a duration, by 'role.channel'."""
        totals: dict[str, float] = {}
        count = 0
        for block in self.stream(role, channels, duration_s):
            count += block.samples
            for name, values in block.channels.items():
                totals[name] = totals.get(name, 0.0) + float(values.sum())
        if not count:
            raise DataError(f"{role}: no sample of {', '.join(channels)} came in {duration_s:g} s")
        return {name: total / count for name, total in totals.items()}

    def lead(self, role: str, drive: str, value: float) -> float:
        """Move a drive to its set-point: at once, or at the rate in the station."""
        rate_per_s = self.rig.led_rate_per_s(role, drive)
        if rate_per_s is None:
            return self.set(role, drive, value)
        allowed, standing = self.rig.allowed(role, drive), self.rig.standing(role, drive)
        # A read-back just out of range at rest, such as -2 mV, starts from the edge of the range.
        start = min(max(standing, allowed.minimum), allowed.maximum)
        if abs(standing - start) > allowed.allowed_deviation:
            start = standing  # it is refused: from there the drive would jump to its range
        return self.ramp(role, drive, start, value, abs(value - start) / rate_per_s)

    def leader(self, role: str, drive: str) -> Callable[[float], float]:
        """Return a function that moves a drive repeatedly, as `lead` does."""
        if self.rig.led_rate_per_s(role, drive) is None:
            return self.setter(role, drive)
        return partial(self.lead, role, drive)

    def ramp(self, role: str, drive: str, start: float, end: float, duration_s: float) -> float:
        """Set a drive repeatedly, so that it follows the line from start to end."""
        actual = self.set(role, drive, start)
        clock = self.rig.clock
        began_s = clock.monotonic_s()
        steps = min(max(ceil(duration_s / _NAP_S), 1), _MOST_RAMP_STEPS)
        for step in range(1, steps + 1):
            fraction = step / steps
            actual = self.set(role, drive, start + fraction * (end - start))
            self.check()
            # From the start of the ramp, so that slow set-points do not add up.
            self.wait(began_s + fraction * duration_s - clock.monotonic_s())
        return actual

    def set(self, role: str, drive: str, value: float) -> float:
        """Set a drive and return its read-back; raise InterlockError if that is forbidden."""
        if self.guard.watching:
            self.guard.allow(role, drive, value)
        return self.rig.set(role, drive, value, self.timeout_s, self.check)

    def setter(self, role: str, drive: str) -> Callable[[float], float]:
        """Return a function that sets a drive repeatedly within this step, as `set` does."""
        # Interlocks can trip between two set-points: each one is checked.
        if self.guard.watching:
            return partial(self.set, role, drive)
        return self.rig.setter(role, drive, self.timeout_s, self.check)

    def check_time(self) -> None:
        """Raise DeviceTimeoutError if the step exceeds its time limit."""
        if self.timeout_s is None:
            return
        if self.rig.clock.monotonic_s() - self.began_s > self.timeout_s:
            raise DeviceTimeoutError(
                f"the step is not done within {self.timeout_s:g} s", hint="see its timeout"
            )


def stopped(stop: StopToken) -> AbortedError:
    """Return the exception for a requested stop, with the reason of the token if it has one."""
    return stop.reason() if isinstance(stop, Reasoned) else AbortedError("stopped on request")


class _Never:
    """The stop token of the teardown, which continues after a stop request."""

    def is_set(self) -> bool:
        return False
