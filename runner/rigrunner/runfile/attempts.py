"""Select the attempt at a step that counts: the last good one. The others are kept beside it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rigrunner.api.data import Measurement
from rigrunner.api.errors import DataError
from rigrunner.api.events import RECORDED, Scanned, StepEnded, StepStarted
from rigrunner.api.member import channel_of
from rigrunner.api.steps import NONE
from rigrunner.api.units import unit
from rigrunner.runfile.codec import packed
from rigrunner.runfile.elapsed import cycles_of, moment, seconds_since
from rigrunner.runfile.parts import Zeros

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from datetime import datetime

    from rigrunner.api.events import Event
    from rigrunner.api.readings import Reading

    _Step = tuple[str, int]

_T = TypeVar("_T")
_MAIN = "main"
ZEROED = "zeroed"
"""The table of the zero readings that have limits."""


def superseded(events: Iterable[Event]) -> frozenset[str]:
    """Return the names of the recordings whose point was repeated successfully."""
    replaced, latest = set[str](), dict[tuple[str, int], str]()
    for event in events:
        if isinstance(event, StepEnded) and event.ok and event.recording:
            step = (event.step, event.index)
            if step in latest:
                replaced.add(latest[step])
            latest[step] = event.recording
    return frozenset(replaced)


class Measured(NamedTuple):
    """The rows of a run, in order."""

    rows: tuple[Measurement, ...]
    """The last completed attempt of each step. These rows count."""
    superseded: tuple[Measurement, ...]
    """The attempts before, which are kept."""
    began: datetime | None
    """When the first step of `main` began.

    By date and time, which continue while a run is interrupted, and over a restart.
    """


class Attempts:
    """Collects the rows of a run from its events, which it takes one by one."""

    def __init__(self) -> None:
        self._make = _Rows()
        self._attempts: list[_Attempt] = []
        self._counting: dict[_Step, _Attempt] = {}

    def take(self, event: Event) -> None:
        """Take the next event."""
        self._make.zeros.take(event)
        match event:
            case StepStarted():
                self._make.start(event)
                # Its rows come one by one, before it is known whether it will be completed.
                if event.action == "scan":
                    self._add(_Attempt((event.step, event.index)))
            case Scanned() if self._attempts:
                self._attempts[-1].rows.append(self._make.of_point(event))
            case StepEnded(ok=True, action="scan") if self._attempts:
                self._attempts[-1].completed = True
                self._count(self._attempts[-1])
            case StepEnded(ok=True) if row := self._make.of_step(event):
                self._add(_Attempt((event.step, event.index), [row], completed=True))

    def measured(self) -> Measured:
        """Return the rows, of each step those of its last completed attempt.

        Of a scan without a completed attempt the points of the last one count: each of them was
        completed.
        """
        last, timed = set(self._counting.values()), self._make.timed
        return Measured(
            tuple(timed(row) for each in self._counting.values() for row in each.rows),
            tuple(timed(row) for each in self._attempts if each not in last for row in each.rows),
            self._make.began,
        )

    def _add(self, attempt: _Attempt) -> None:
        self._attempts.append(attempt)
        self._count(attempt)

    def _count(self, attempt: _Attempt) -> None:
        """Let an attempt count, in its order, unless only an earlier one was completed."""
        before = self._counting.get(attempt.step)
        if attempt.completed or before is None or not before.completed:
            # To the end: the rows stand in the order in which they were measured.
            self._counting.pop(attempt.step, None)
            self._counting[attempt.step] = attempt


@dataclass(eq=False, slots=True)
class _Attempt:
    """The rows of one attempt at a step."""

    step: _Step
    rows: list[Measurement] = field(default_factory=list)
    completed: bool = False


_UNKNOWN = StepStarted(seq=0, monotonic_s=0.0, utc="", step="", index=0, action="", text="")


@dataclass(eq=False)
class _Rows:
    """Makes rows of events. What many rows have in common, such as their limits, is held once."""

    started: StepStarted = _UNKNOWN
    """The start of the present step. It has the limits, and for a scan the units."""
    zeros: Zeros = field(default_factory=Zeros)
    began: datetime | None = None
    _common: dict[bytes, Any] = field(default_factory=dict)
    """Units, limits and shown units of rows by all that these follow from."""
    _held: dict[bytes, Any] = field(default_factory=dict)

    def start(self, event: StepStarted) -> None:
        """Begin with the rows of a step."""
        self.started = event
        if self.began is None and event.step.startswith(_MAIN):
            self.began = moment(event.utc)

    def timed(self, row: Measurement) -> Measurement:
        """Return a row with its time, also if `main` had not begun when it was made."""
        if row.elapsed_s is not None:
            return row
        elapsed_s = seconds_since(self.began, row.utc)
        return row if elapsed_s is None else replace(row, elapsed_s=elapsed_s)

    def of_point(self, event: Scanned) -> Measurement:
        """Return the row of a point of a scan."""
        known = self.started.units
        return self._row(event.measurement, event.utc, event.setpoints, event.values, known)

    def of_step(self, event: StepEnded) -> Measurement | None:
        """Return the row of a step, or None for a step without one.

        A zero or a recording gives a row of its values with limits, and a recording one of its
        statistics.
        """
        table, started, setpoints = event.measurement, self.started, self.started.setpoints
        if table:
            known, readings = event.units, event.readings
            return self._row(
                table, event.utc, event.setpoints, event.values, known, readings=readings
            )
        if not (started.limits or event.statistics):
            return None
        found = {**event.values, **event.statistics}
        values = {limit.of: found[limit.of] for limit in started.limits if limit.of in found}
        values |= event.statistics
        known = {**started.units, **event.units}
        members = (*setpoints, *values)
        # Of a value, of a drive, or of the channel of a statistic.
        symbols = {name: known.get(name) or known.get(channel_of(name), "") for name in members}
        units = {name: symbol for name, symbol in symbols.items() if symbol}
        table = ZEROED if event.action == "zero" else RECORDED
        return self._row(table, event.utc, setpoints, values, units, recording=event.recording)

    def _row(
        self,
        table: str,
        utc: str,
        setpoints: Mapping[str, float],
        values: Mapping[str, float],
        known: Mapping[str, str],
        *,
        readings: Mapping[str, Reading] = NONE,
        recording: str = "",
    ) -> Measurement:
        """Return a row with its coordinates and its time."""
        started = self.started
        found, told = started.coordinates, started.written_in
        names = (*setpoints,), (*values,), (*readings,), (*found,)
        of = packed((names, known, started.units, told, started.limits))
        if of not in self._common:
            units = {name: known[name] for each in names[:3] for name in each if name in known}
            units |= {name: started.units[name] for name in found if name in started.units}
            shown = {name: each for name in values if (each := _shown_in(name, told))}
            shown |= {name: told[name] for name in (*setpoints, *found) if name in told}
            self._common[of] = [self._once(each) for each in (units, started.limits, shown)]
        units, limits, shown = self._common[of]
        return Measurement(
            table,
            utc,
            setpoints,
            values,
            units,
            limits,
            recording,
            coordinates=self._once(found),
            elapsed_s=seconds_since(self.began, utc),
            cycles=cycles_of(started, values),
            readings=readings or NONE,
            expected=started.expected if readings else (),
            written_in=shown,
            zeros=self.zeros.in_force,
        )

    def _once(self, part: _T) -> _T:
        """Return the part of an earlier row that is the same, or else this one."""
        held: _T = self._held.setdefault(packed(part), part)
        return held


def _shown_in(name: str, told: Mapping[str, str]) -> str:
    """Return the display unit of a value. A spread of a temperature is shown in K."""
    try:
        channel = channel_of(name)
    except ValueError as error:
        raise DataError(f"a record of the run has a value '{name}', expected role.name") from error
    shown, statistic = told.get(channel, ""), name.removeprefix(channel)
    follows = statistic in {"", ".mean", ".minimum", ".maximum"}
    return shown if shown and (follows or not unit(shown).offset) else ""
