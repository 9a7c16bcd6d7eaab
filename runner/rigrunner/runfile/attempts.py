"""Select the attempt at a step that counts: the last good one. The others are kept beside it."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field, replace
from itertools import chain, pairwise
from sys import intern
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rigrunner.api.data import Measurement
from rigrunner.api.errors import DataError
from rigrunner.api.events import RECORDED, Scanned, StepEnded, StepStarted
from rigrunner.api.member import channel_of
from rigrunner.api.steps import NONE
from rigrunner.api.units import unit
from rigrunner.runfile.codec import packed
from rigrunner.runfile.digest import lines_of
from rigrunner.runfile.elapsed import cycles_of, moment, seconds_since
from rigrunner.runfile.parts import Zeros

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping
    from datetime import datetime

    from rigrunner.api.events import Event
    from rigrunner.api.readings import Reading

_T = TypeVar("_T")
_MAIN = "main"
ZEROED = "zeroed"
"""The table of the zero readings that have limits."""


def superseded(events: Iterable[Event]) -> frozenset[str]:
    """Return the names of the recordings whose point was repeated successfully."""
    repeated, latest = set[str](), dict[int, str]()
    for event in events:
        if isinstance(event, StepEnded) and event.ok and event.recording:
            if event.index in latest:
                repeated.add(latest[event.index])
            latest[event.index] = event.recording
    return frozenset(repeated)


class MeasuredRows(NamedTuple):
    """The rows of a run, in order."""

    rows: tuple[Measurement, ...]
    """The last completed attempt of each step. These rows count."""
    superseded: tuple[Measurement, ...]
    """The attempts before, which are kept."""
    began: datetime | None
    """When the first step of `main` began.

    By date and time, which continue while a run is interrupted, and over a restart.
    """
    digests: str | None = None
    """The digests of the rows that count, one a line, where the rows themselves are not kept."""


class Attempts:
    """Collects the rows of a run from its events, which it takes one by one."""

    def __init__(self, digest: Callable[[Measurement], str] | None = None) -> None:
        """Keep the rows, or the `digest` of each in its place."""
        self._digest = digest
        self._maker = _RowMaker()
        self._kept: list[Any] = []
        # Of each attempt in order: the index of its step, which is its own among all steps of a
        # run, the number of its first row, and whether it was completed.
        self._steps, self._first, self._completed = array("q"), array("q"), bytearray()

    def take(self, event: Event) -> None:
        """Take the next event."""
        self._maker.zeros.take(event)
        match event:
            case StepStarted():
                self._maker.start(event)
                # Its rows come one by one, before it is known whether it will be completed.
                if event.action == "scan":
                    self._begin(event.index, completed=False)
            case Scanned() if self._steps:
                self._store(self._maker.of_point(event))
            case StepEnded(ok=True, action="scan") if self._steps:
                self._completed[-1] = True
            case StepEnded(ok=True) if row := self._maker.of_step(event):
                self._begin(event.index, completed=True)
                self._store(row)

    def measured(self) -> MeasuredRows:
        """Return the rows, of each step those of its last completed attempt.

        Of a scan without a completed attempt the points of the last one count: each of them was
        completed.
        """
        latest: dict[int, int] = {}
        counts = bytearray(len(self._steps))
        for number, step in enumerate(self._steps):
            previous = latest.get(step, number)
            if self._completed[number] or not self._completed[previous]:
                counts[previous], counts[number], latest[step] = False, True, number
        began, timed = self._maker.began, self._maker.with_time
        if self._digest is not None:
            return MeasuredRows((), (), began, lines_of(self._rows(counts, which=True)))
        counting, others = (map(timed, self._rows(counts, which=which)) for which in (True, False))
        return MeasuredRows(tuple(counting), tuple(others), began)

    def _begin(self, step: int, *, completed: bool) -> None:
        self._steps.append(step)
        self._first.append(len(self._kept))
        self._completed.append(completed)

    def _store(self, row: Measurement) -> None:
        self._kept.append(row if self._digest is None else self._digest(row))

    def _rows(self, counts: bytearray, *, which: bool) -> Iterator[Any]:
        """Yield the rows of the attempts that count, or of the others, in order."""
        ends = pairwise(chain(self._first, (len(self._kept),)))
        for (first, end), count in zip(ends, counts, strict=True):
            if count == which:
                yield from self._kept[first:end]


_UNKNOWN = StepStarted(seq=0, monotonic_s=0.0, utc="", step="", index=0, action="", text="")


@dataclass(eq=False)
class _RowMaker:
    """Makes rows of events. What many rows have in common, such as their limits, is stored once."""

    started: StepStarted = _UNKNOWN
    """The start of the present step. It has the limits, and for a scan the units."""
    zeros: Zeros = field(default_factory=Zeros)
    began: datetime | None = None
    _common: dict[bytes, Any] = field(default_factory=dict)
    """Units, limits and shown units of rows by all that these follow from."""
    _parts: dict[bytes, Any] = field(default_factory=dict)

    def start(self, event: StepStarted) -> None:
        """Begin with the rows of a step."""
        self.started = event
        if self.began is None and event.step.startswith(_MAIN):
            self.began = moment(event.utc)

    def with_time(self, row: Measurement) -> Measurement:
        """Return a row with its time, also if `main` had not begun when it was made."""
        if row.elapsed_s is not None:
            return row
        elapsed_s = seconds_since(self.began, row.utc)
        return row if elapsed_s is None else replace(row, elapsed_s=elapsed_s)

    def of_point(self, event: Scanned) -> Measurement:
        """Return the row of a point of a scan."""
        units = self.started.units
        return self._row(event.measurement, event.utc, event.setpoints, event.values, units)

    def of_step(self, event: StepEnded) -> Measurement | None:
        """Return the row of a step, or None for a step without one.

        A zero or a recording gives a row of its values with limits, and a recording one of its
        statistics.
        """
        table, started, setpoints = event.measurement, self.started, self.started.setpoints
        if table:
            units, readings = event.units, event.readings
            return self._row(
                table, event.utc, event.setpoints, event.values, units, readings=readings
            )
        if not (started.limits or event.statistics):
            return None
        measured = {**event.values, **event.statistics}
        values = {limit.of: measured[limit.of] for limit in started.limits if limit.of in measured}
        values |= event.statistics
        units = {**started.units, **event.units}
        members = (*setpoints, *values)
        # Of a value, of a drive, or of the channel of a statistic.
        symbols = {name: units.get(name) or units.get(channel_of(name), "") for name in members}
        units = {name: symbol for name, symbol in symbols.items() if symbol}
        table = ZEROED if event.action == "zero" else RECORDED
        return self._row(table, event.utc, setpoints, values, units, recording=event.recording)

    def _row(
        self,
        table: str,
        utc: str,
        setpoints: Mapping[str, float],
        values: Mapping[str, float],
        symbols: Mapping[str, str],
        *,
        readings: Mapping[str, Reading] = NONE,
        recording: str = "",
    ) -> Measurement:
        """Return a row with its coordinates and its time."""
        started = self.started
        coordinates, written_in = started.coordinates, started.written_in
        names = (*setpoints,), (*values,), (*readings,), (*coordinates,)
        key = packed((names, symbols, started.units, written_in, started.limits))
        if key not in self._common:
            measured = (*setpoints, *values, *readings)
            units = {name: symbols[name] for name in measured if name in symbols}
            units |= {name: started.units[name] for name in coordinates if name in started.units}
            shown = {name: symbol for name in values if (symbol := _display_unit(name, written_in))}
            shown |= {n: written_in[n] for n in (*setpoints, *coordinates) if n in written_in}
            self._common[key] = [self._shared(part) for part in (units, started.limits, shown)]
        units, limits, shown = self._common[key]
        return Measurement(
            intern(table),
            utc,
            setpoints,
            values,
            units,
            limits,
            recording,
            coordinates=self._shared(coordinates),
            elapsed_s=seconds_since(self.began, utc),
            cycles=cycles_of(started, values),
            readings=readings or NONE,
            expected=started.expected if readings else (),
            written_in=shown,
            zeros=self.zeros.in_force,
        )

    def _shared(self, part: _T) -> _T:
        """Return the part of an earlier row that is the same, or else this one."""
        first: _T = self._parts.setdefault(packed(part), part)
        return first


def _display_unit(name: str, written_in: Mapping[str, str]) -> str:
    """Return the display unit of a value. A spread of a temperature is shown in K."""
    try:
        channel = channel_of(name)
    except ValueError as error:
        raise DataError(f"a record of the run has a value '{name}', expected role.name") from error
    shown, statistic = written_in.get(channel, ""), name.removeprefix(channel)
    follows = statistic in {"", ".mean", ".minimum", ".maximum"}
    return shown if shown and (follows or not unit(shown).offset) else ""
