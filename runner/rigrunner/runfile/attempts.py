"""Select the attempt at a step that counts: the last good one. The others are kept beside it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rigrunner.api.data import Measurement
from rigrunner.api.errors import DataError
from rigrunner.api.events import RECORDED, Scanned, StepEnded, StepStarted
from rigrunner.api.member import channel_of
from rigrunner.api.units import unit
from rigrunner.runfile.codec import packed
from rigrunner.runfile.elapsed import cycles_of, main_began, seconds_since

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from datetime import datetime

    from rigrunner.api.events import Event

    _Step = tuple[str, int]

_T = TypeVar("_T")
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


def measured(events: Sequence[Event]) -> Measured:
    """Return the measured rows, of each step by its last completed attempt.

    Of a scan without a completed attempt the points of the last one count: each of them was
    completed.
    """
    began, once = main_began(events), _Once()
    attempts: list[_Attempt] = []
    counting: dict[_Step, _Attempt] = {}
    started: StepStarted | None = None
    for event in events:
        match event:
            case StepStarted():
                started = event
                # Its rows come one by one, before it is known whether it will be completed.
                if event.action == "scan":
                    attempts.append(_Attempt((event.step, event.index)))
                    _count(attempts[-1], counting)
            case Scanned() if attempts:
                attempts[-1].rows.append(_row(event, started, began, once))
            case StepEnded(ok=True, action="scan") if attempts:
                attempts[-1].completed = True
                _count(attempts[-1], counting)
            case StepEnded(ok=True) if row := _row_of_step(event, started, began, once):
                attempts.append(_Attempt((event.step, event.index), [row], completed=True))
                _count(attempts[-1], counting)
    last = set(counting.values())
    return Measured(
        tuple(row for each in counting.values() for row in each.rows),
        tuple(row for each in attempts if each not in last for row in each.rows),
    )


@dataclass(eq=False, slots=True)
class _Attempt:
    """The rows of one attempt at a step."""

    step: _Step
    rows: list[Measurement] = field(default_factory=list)
    completed: bool = False


def _count(attempt: _Attempt, counting: dict[_Step, _Attempt]) -> None:
    """Let an attempt count, in its order, unless only an earlier one was completed."""
    before = counting.get(attempt.step)
    if attempt.completed or before is None or not before.completed:
        # To the end: the rows stand in the order in which they were measured.
        counting.pop(attempt.step, None)
        counting[attempt.step] = attempt


class _Once:
    """Holds what many rows have in common once, such as their limits."""

    def __init__(self) -> None:
        self._held: dict[bytes, Any] = {}

    def __call__(self, part: _T) -> _T:
        """Return the part of an earlier row that is the same, or else this one."""
        held: _T = self._held.setdefault(packed(part), part)
        return held


def _row_of_step(
    event: StepEnded, started: StepStarted | None, began: datetime | None, once: _Once
) -> Measurement | None:
    """Return the row of a step, or None for a step without one.

    A zero or a recording gives a row of its values with limits, and a recording one of its
    statistics.
    """
    if event.measurement:
        row = _row(event, started, began, once)
        if not event.readings:
            return row
        units = {name: event.units[name] for name in event.readings if name in event.units}
        expected = started.expected if started is not None else ()
        known = {**row.units, **units}
        return replace(row, readings=event.readings, expected=expected, units=known)
    limits = started.limits if started is not None else ()
    if not (limits or event.statistics):
        return None
    found = {**event.values, **event.statistics}
    values = {limit.of: found[limit.of] for limit in limits if limit.of in found}
    values |= event.statistics
    known = {**(started.units if started else {}), **event.units}
    setpoints = started.setpoints if started is not None else {}
    members = (*setpoints, *values)
    # Of a value, of a drive, or of the channel of a statistic.
    symbols = {name: known.get(name) or known.get(channel_of(name), "") for name in members}
    units = {name: symbol for name, symbol in symbols.items() if symbol}
    table = ZEROED if event.action == "zero" else RECORDED
    row = Measurement(table, event.utc, setpoints, values, units, limits, event.recording)
    return _placed(row, started, began, once)


def _row(
    event: StepEnded | Scanned, started: StepStarted | None, began: datetime | None, once: _Once
) -> Measurement:
    """Return a row. Its start event has the limits, and for a scan the units."""
    known = event.units if isinstance(event, StepEnded) else started.units if started else {}
    members = (*event.setpoints, *event.values)
    units = {member: known[member] for member in members if member in known}
    limits = started.limits if started is not None else ()
    row = Measurement(event.measurement, event.utc, event.setpoints, event.values, units, limits)
    return _placed(row, started, began, once)


def _placed(
    row: Measurement, started: StepStarted | None, began: datetime | None, once: _Once
) -> Measurement:
    """Return a row with its coordinates and its time."""
    found = started.coordinates if started is not None else {}
    known = started.units if started is not None else {}
    units = {name: known[name] for name in found if name in known}
    told = started.written_in if started is not None else {}
    return replace(
        row,
        coordinates=once(found),
        units=once({**row.units, **units}),
        limits=once(row.limits),
        elapsed_s=seconds_since(began, row.utc),
        cycles=cycles_of(started, row.values),
        readings=once(row.readings),
        written_in=once(
            {
                **{name: each for name in row.values if (each := _shown_in(name, told))},
                **{name: told[name] for name in (*row.setpoints, *found) if name in told},
            }
        ),
    )


def _shown_in(name: str, told: Mapping[str, str]) -> str:
    """Return the display unit of a value. A spread of a temperature is shown in K."""
    try:
        channel = channel_of(name)
    except ValueError as error:
        raise DataError(f"a record of the run has a value '{name}', expected role.name") from error
    shown, statistic = told.get(channel, ""), name.removeprefix(channel)
    follows = statistic in {"", ".mean", ".minimum", ".maximum"}
    return shown if shown and (follows or not unit(shown).offset) else ""
