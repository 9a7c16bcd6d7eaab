"""The values of an analysis: channels of recordings or columns of tables."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Component, DataError, unit
from rigrunner.api.data import place_of
from rigrunner.api.member import channel_of
from rigrunner.api.places import is_at
from rigrunner.api.units import si_symbol
from rigrunner_plugins.analyses.settings import unit_of_errors
from rigrunner_plugins.analyses.statistics import Series

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner.api import Array, Measurement, Quantity, Recording, RunData
    from rigrunner.api.accuracy import ReadingError
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.data import ZeroReading


@dataclass(frozen=True, eq=False)
class Group:
    """All values at one place, for each requested channel, shape (n,)."""

    place: Mapping[str, CoordinateValue]
    values: Mapping[str, Array]
    units: Mapping[str, str]
    times_s: Array
    in_a_row: bool
    step_s: float
    set_points: Sequence[str] = ()
    """The names of values that were set, not read."""
    starts: tuple[int, ...] = ()
    """The index at which each recording but the first begins."""
    labels: tuple[tuple[int, ...], ...] = ()
    """Of rows: for each label or counter with several values, which one each row has."""

    zeros: Mapping[str, tuple[ZeroReading, ...]] = field(default_factory=dict)
    """By channel, the zero reading that was subtracted from each recording or row."""

    def zero_errors(self, run: RunData, channel: str) -> Iterator[tuple[ReadingError, Array]]:
        """Yield the error of each zero of a channel, with 1 for the values that have it, else 0.

        Of several rows, a zero of one row alone is left out: their scatter shows it.
        """
        zeros = alike(self.zeros.get(channel, ()))
        for zero, count in Counter(zeros).items():
            error = run.zero_error(channel, zero)
            if error is not None and (self.in_a_row or count > 1 or len(zeros) == 1):
                sizes = np.diff([0, *self.starts, len(self.times_s)])
                yield error, np.repeat([float(each == zero) for each in zeros], sizes)

    def series(self, values: Array) -> Series:
        """Return the values of the group as a series."""
        return Series(values, self.times_s, self.in_a_row, self.step_s, self.starts, self.labels)


def alike(zeros: Sequence[ZeroReading]) -> list[ZeroReading]:
    """Return the zeros of one result, in place of equal readings at rest the first of them.

    A display rounds what it shows at rest alike each time: the mean of such zeros is no better.
    """
    first = {zero.value: zero for zero in reversed(zeros)}
    return [first[zero.value] if zero.u == 0 else zero for zero in zeros]


@dataclass(frozen=True, eq=False)
class Part:
    """A recording or a table row."""

    place: Mapping[str, CoordinateValue]
    values: Mapping[str, Array]
    """Values of each requested channel minus its zero reading, shape (n,): samples, or one value.
    """
    units: Mapping[str, str]
    began: datetime
    step_s: float
    """Time between two samples in s; 0 for a table row."""
    written_in: Mapping[str, str] = field(default_factory=dict)
    """Units for display other than SI, by channel."""
    labels: Mapping[str, object] = field(default_factory=dict)
    """Of a row: its labels and counters."""
    zeros: Mapping[str, ZeroReading] = field(default_factory=dict)
    """The zero reading that was subtracted, by channel."""


def groups(
    run: RunData,
    names: Sequence[str],
    *,
    set_points: Sequence[str] = (),
    per: Sequence[str] = (),
    where: Mapping[str, Quantity | str] | None = None,
    table: str | None = None,
) -> list[Group]:
    """Return the values of some channels by place, in order of first appearance.

    `set_points` are set-points whose values are needed beside each reading. `per` are the
    coordinates that distinguish places; `where` and `table` select. Zero readings are subtracted.
    Raises DataError if nothing was measured or set, or a value is not finite.
    """
    measured = list(parts(run, names, table))
    chosen = [part for part in measured if is_at(where or {}, part.place)]
    if not chosen:
        condition = ", ".join(f"{name} = {value}" for name, value in (where or {}).items())
        raise DataError(
            f"{' and '.join(names)} {'were' if names[1:] else 'was'} not measured"
            f"{f' at {condition}' if measured and condition else ''}",
            hint="measure or record it in the procedure, at one step together",
        )
    parts_by_place: dict[tuple[object, ...], list[Part]] = {}
    for part in chosen:
        # As values, a set-point counts once for each sample, or of a row once.
        count = max((len(values_) for values_ in part.values.values()), default=1)
        set_ = {name: np.full(count, set_value(part, name)) for name in set_points}
        units = {name: set_unit(part, name) for name in set_points}
        extended = replace(part, values={**part.values, **set_}, units={**part.units, **units})
        key = tuple(coordinate.usual for coordinate in _place_by(part, per))
        parts_by_place.setdefault(key, []).append(extended)
    return [
        _group(dict(zip(per, _place_by(place_parts[0], per), strict=True)), place_parts, set_points)
        for place_parts in parts_by_place.values()
    ]


def is_read(run: RunData, name: str, beside: str = "") -> bool:
    """Return whether a channel was read in a run, together with another if one is named."""
    names = {name, beside or name}
    return any(
        names <= read.keys()
        for read in (
            *(recording.channels for recording in run.recordings),
            *(row.values for row in run.measurements),
        )
    )


def coordinate_of(part: Part, name: str) -> CoordinateValue:
    """Return a set-point, counter or label at which a part was measured; raise DataError."""
    if name not in part.place:
        names = ", ".join(part.place) or "none"
        raise DataError(f"'{name}' was neither measured with it nor set; known: {names}")
    return part.place[name]


def set_value(part: Part, name: str) -> float:
    """Return a set-point or counter in its SI unit; raise DataError for a text."""
    coordinate = coordinate_of(part, name)
    if isinstance(coordinate.value, str):
        raise DataError(f"'{name}' is the text '{coordinate.value}', and a number is needed")
    unit_ = unit(coordinate.unit or "1")
    return coordinate.value * unit_.factor + unit_.offset


def set_unit(part: Part, name: str) -> str:
    """Return the SI unit of a set-point or counter."""
    return si_symbol(unit(coordinate_of(part, name).unit or "1").dimension)


def _place_by(part: Part, per: Iterable[str]) -> Iterator[CoordinateValue]:
    for name in per:
        if name not in part.place:
            names = ", ".join(part.place) or "none"
            raise DataError(f"'{name}' does not distinguish values: it was not set; known: {names}")
        yield part.place[name]


def _group(
    place: Mapping[str, CoordinateValue], parts: list[Part], set_points: Sequence[str]
) -> Group:
    names = parts[0].values
    values = {name: np.concatenate([part.values[name] for part in parts]) for name in names}
    for name, channel_values in values.items():
        if not np.isfinite(channel_values).all():
            raise DataError(f"{name}: a value is not a finite number")
    first = parts[0].began
    count = {id(part): len(next(iter(part.values.values()))) for part in parts}
    times = [
        (part.began - first).total_seconds() + part.step_s * np.arange(count[id(part)])
        for part in parts
    ]
    return Group(
        place=place,
        values=values,
        units=parts[0].units,
        times_s=np.concatenate(times),
        in_a_row=any(part.step_s for part in parts),
        step_s=max(part.step_s for part in parts),
        set_points=set_points,
        starts=tuple(np.cumsum([count[id(part)] for part in parts])[:-1].tolist()),
        labels=tuple(_labels(parts)),
        zeros={name: tuple(part.zeros[name] for part in parts) for name in parts[0].zeros},
    )


def _labels(parts: Sequence[Part]) -> Iterator[tuple[int, ...]]:
    """Yield, for each label of single rows with several values, the number of the value of each."""
    if any(part.step_s for part in parts):
        return
    for name in parts[0].labels:
        values = [part.labels.get(name) for part in parts]
        order = list(dict.fromkeys(values))
        if 1 < len(order) < len(parts):
            yield tuple(map(order.index, values))


def parts(run: RunData, names: Sequence[str], table: str | None = None) -> Iterator[Part]:
    """Yield each recording with all the channels; else each row, or those of a table."""
    recordings = [each for each in run.recordings if all(name in each.channels for name in names)]
    if table is None and recordings:
        for recording in recordings:
            yield _part_of_recording(recording, run, names)
        return
    for row in run.measurements:
        if table not in {None, row.name}:
            continue
        # Of its samples only the statistics were kept: the channel as such has no value there.
        if row.recording and all(name == channel_of(name) for name in names):
            continue
        if all(name in row.values for name in names):
            zeros = {n: run.zero_of(row, channel_of(n)) for n in names if _is_zeroed(n)}
            values = {name: np.array([_reading(name, row, run, zeros)]) for name in names}
            began = datetime.fromisoformat(row.utc)
            place, shown = place_of(row), row.written_in
            yield Part(place, values, row.units, began, 0.0, shown, row.coordinates, zeros)


def _is_zeroed(name: str) -> bool:
    """Return whether a zero is subtracted from a value: not from a spread or a root mean square."""
    return name.removeprefix(channel_of(name)) in {"", ".mean", ".minimum", ".maximum"}


def _reading(name: str, row: Measurement, run: RunData, zeros: Mapping[str, ZeroReading]) -> float:
    value = row.values[name]
    if name not in zeros:
        return value
    return float(run.readings(channel_of(name), np.array([value]), zeros[name].value)[0])


def _part_of_recording(recording: Recording, run: RunData, names: Sequence[str]) -> Part:
    zeros = {name: run.zero_of(recording, name) for name in names}
    values = {
        name: run.readings(name, np.asarray(recording.channels[name]), zeros[name].value)
        for name in names
    }
    began = datetime.fromisoformat(recording.started_utc)
    step_s = 1 / recording.rate_hz
    place, shown = place_of(recording), recording.written_in
    return Part(place, values, recording.units, began, step_s, shown, zeros=zeros)


def line_name(error: ReadingError) -> str:
    """Return the name of the budget line of an error: with its source, if that is stated."""
    return f"{error.name} ({error.source})" if error.source else error.name


def error_line(error: ReadingError, name: str, effect: float, symbol: str) -> Component:
    """Return the budget line of an error, from the change of the result by an error of 1.

    `symbol` is the SI unit of the readings.
    """
    return Component(
        name=name,
        u=abs(effect) * error.u,
        dof=error.dof,
        distribution=error.distribution,
        common=True,
        value=0.0,
        unit="1" if error.acts == "gain" else unit_of_errors(symbol),
        input_u=error.u,
        sensitivity=effect,
        shared=error.acts != "each",
    )
