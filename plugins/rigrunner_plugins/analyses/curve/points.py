"""The points of a curve: values of y over x, one from each recording or table row."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain
from math import hypot, nan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rigrunner.api import DataError, Points, unit
from rigrunner.api.member import channel_of
from rigrunner.api.places import is_at
from rigrunner_plugins.analyses.sources import (
    alike,
    coordinate_of,
    is_read,
    parts,
    set_unit,
    set_value,
)
from rigrunner_plugins.analyses.statistics import STATISTICS, Series

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api import Array, RunData
    from rigrunner.api.accuracy import ReadingError
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner_plugins.analyses.curve.settings import CurveSettings
    from rigrunner_plugins.analyses.curve.shared_lines import SharedLine
    from rigrunner_plugins.analyses.sources import Part

CELSIUS = 273.15
STEP = 1e-6
"""Shift of points used to find the effect of an error, as a share of their range."""
LEAST_RANGE = 1e-4
"""Of y, as a share of its largest value."""
MOST_WIDENED = 1e4
MOST_MOVED = 500
"""Up to this number, points are shifted one by one to find their effects; above it, in groups."""


class Shares(NamedTuple):
    """How much of an error each value has: 1 for all of it."""

    points: Array
    """Shape (n,)."""
    requested_y: Array
    """Of the requested y, which are from the same instrument as y, shape (m,)."""


@dataclass(frozen=True, eq=False)
class Values:
    """The points of one curve, in SI units; x is relative to `origin`."""

    x: Array
    """Shape (n, k)."""
    y: Array
    """Shape (n,)."""
    u_y: Array | None
    """Standard uncertainty of each y from the scatter in its recording, shape (n,)."""
    dof_y: Array | None
    """Its degrees of freedom, shape (n,), of a known `u_y`."""
    requested_y: Array
    """Values of y for which x is requested, shape (m,); nan for one that was not measured."""
    origin: float
    names: tuple[str, ...]
    """Names of the columns of x."""
    units: tuple[str, ...]
    """SI units of the columns of x."""
    y_unit: str
    y_name: str
    shown: tuple[str, ...]
    """Units of the columns of x for display, as the procedure has them."""
    y_shown: str
    is_set: bool = False
    """Whether x are set-points, counters or labels, not readings."""
    u_x: Array | None = None
    """Standard uncertainty of one x from its scatter, shape (n,)."""

    def points(self) -> Points:
        """Return the points in the form that a fit takes."""
        has_several_x = len(self.names) > 1
        return Points(
            self.x if has_several_x else self.x[:, 0],
            self.y,
            self.u_y,
            x_unit="" if has_several_x or self.units[0] == "1" else _divisor(self.units[0]),
            y_unit="" if self.y_unit == "1" else self.y_unit,
            regressors=self.names if has_several_x else (),
            x_name=self.names[0].rpartition(".")[2],
            y_name=self.y_name.rpartition(".")[2],
            dof_y=self.dof_y,
            u_x=self.u_x,
        )

    def with_error(self, column: int | None, acts: str, size: float, shares: Shares) -> Values:
        """Return the values with a gain or an offset in y (`column` None) or in a column of x."""
        points, requested = size * shares.points, size * shares.requested_y
        if column is None:
            y = self.y * (1 + points) if acts == "gain" else self.y + points
            old = self.requested_y
            new = old * (1 + requested) if acts == "gain" else old + requested
            return replace(self, y=y, requested_y=new)
        x = self.x.copy()
        x[:, column] += points * (x[:, column] + self.origin) if acts == "gain" else points
        return replace(self, x=x)

    def subset(self, rows: Array) -> Values:
        """Return some of the points; `rows` is a mask, shape (n,)."""
        u_y, dof_y, u_x = (
            None if array is None else array[rows] for array in (self.u_y, self.dof_y, self.u_x)
        )
        return replace(self, x=self.x[rows], y=self.y[rows], u_y=u_y, dof_y=dof_y, u_x=u_x)

    def shifted(self, column: int | None, rows: Array, size: float) -> Values:
        """Return the values with some y, or some x of a column, increased by a shift."""
        if column is None:
            y = self.y.copy()
            y[rows] += size
            return replace(self, y=y)
        x = self.x.copy()
        x[rows, column] += size
        return replace(self, x=x)

    def shifted_by(self, by: Array, rows: Array | slice) -> tuple[Values, float]:
        """Return the values with some rows moved by a share of `by`, and that share.

        `by` is the change of y and of each column of x, shape (1 + k, n).
        """
        moved = np.vstack([self.y, self.x.T])
        share = STEP / float((np.abs(by).max(axis=1) / self.ranges).max())
        moved[:, rows] += share * by[:, rows]
        return replace(self, y=moved[0], x=moved[1:].T), share

    @property
    def ranges(self) -> Array:
        """The range of y and of each x, of which `STEP` is a shift, shape (1 + k,).

        Of a y that hardly changes, such as 10 MHz within 1 Hz, the shift must change more than its
        last digits.
        """
        ranges = np.ptp(np.vstack([self.y, self.x.T]), axis=1)
        least_y = LEAST_RANGE * float(np.abs(self.y).max())
        ranges[1:] *= np.clip(least_y / ranges[0], 1.0, MOST_WIDENED) if ranges[0] else 1.0
        ranges[0] = max(ranges[0], least_y)
        ranges[ranges == 0] = 1.0
        return np.asarray(ranges)

    def rows(self) -> Sequence[Array]:
        """Return which points are shifted together; each one alone if there are few."""
        # Neighbours in x go together: as a rule they move a value in the same direction.
        order = np.lexsort(self.x.T[::-1])
        return np.array_split(order, min(len(order), MOST_MOVED))


@dataclass(frozen=True, eq=False)
class Source:
    """The values of one curve and where they were measured."""

    place: Mapping[str, CoordinateValue]
    values: Values
    places: tuple[Mapping[str, CoordinateValue], ...]
    """The place of each point."""
    counts: tuple[int, ...]
    """The number of readings that each requested y is the mean of; 0 for an exact value."""
    errors: Mapping[str, tuple[ReadingError, ...]]
    """The possible errors of the readings of y, and of each x that has errors."""
    of_zeros: tuple[tuple[str, ReadingError, Shares], ...]
    """The errors of zeros, each with its channel and what it was subtracted from."""
    exact: tuple[str, ...]
    """Set-points that are not in the register, taken as exact."""
    lines: tuple[SharedLine, ...] = ()
    """The budget lines of points that are results of other analyses."""
    left_out: tuple[str, ...] = ()
    """Places at which such a result has no value."""


def sources(run: RunData, settings: CurveSettings) -> Iterator[Source]:
    """Yield the points of each curve; raise DataError if nothing was measured."""
    read = tuple(
        name for name in dict.fromkeys(settings.over.values()) if is_read(run, name, settings.of)
    )
    measured = list(parts(run, [settings.of, *read], settings.table))
    chosen = [part for part in measured if is_at(settings.where, part.place)]
    if not chosen:
        where = ", ".join(f"{name} = {value}" for name, value in settings.where.items())
        raise DataError(
            f"{settings.of} was not measured{f' at {where}' if measured and where else ''}",
            hint="measure or record it in the procedure, together with what it is over",
        )
    groups: dict[tuple[object, ...], list[Part]] = {}
    for part in chosen:
        key = tuple(coordinate_of(part, name).usual for name in settings.per)
        groups.setdefault(key, []).append(part)
    for curve_parts in groups.values():
        place = {name: curve_parts[0].place[name] for name in settings.per}
        keys = {name: coordinate.usual for name, coordinate in place.items()}
        all_parts = [
            part
            for part in measured
            if all(
                name in part.place and part.place[name].usual == key for name, key in keys.items()
            )
        ]
        yield _source(run, settings, place, curve_parts, all_parts)


def _source(
    run: RunData,
    settings: CurveSettings,
    place: Mapping[str, CoordinateValue],
    parts: Sequence[Part],
    all_parts: Sequence[Part],
) -> Source:
    columns = [[_x(part, source, settings.statistic) for part in parts]
               for source in settings.over.values()]  # fmt: skip
    units = [_unit(parts[0], source) for source in settings.over.values()]
    origin = origin_of(settings, units)
    x = np.array(columns, np.float64).T - origin
    y = np.array([_statistic(part, settings.of, settings.statistic) for part in parts])
    requested_y, counts = _requested_y(settings, all_parts)
    values = Values(
        x, y, *_scatter(run, parts, settings.of, settings), requested_y, origin,
        tuple(settings.over), tuple(units),
        parts[0].units[settings.of], settings.of,
        tuple(_shown(parts[0], source) for source in settings.over.values()),
        _shown(parts[0], settings.of),
        is_set=not any(name in parts[0].values for name in settings.over.values()),
        u_x=_scatter_of_x(run, parts, settings),
    )  # fmt: skip
    measured = requested_y[np.array(counts, int) > 0]
    if not (np.isfinite(x).all() and np.isfinite(y).all() and np.isfinite(measured).all()):
        raise DataError(f"{settings.of} over {', '.join(settings.over.values())}: a value is not a"
                        " finite number")  # fmt: skip
    largest = {settings.of: float(np.abs(y).max())}
    largest |= {
        source: float(np.abs(column + origin).max())
        for source, column in zip(settings.over.values(), x.T, strict=True)
        if source in parts[0].values or ("." in source and source in run.instruments)
    }
    return Source(
        place=place,
        values=values,
        places=tuple(part.place for part in parts),
        counts=counts,
        errors={name: run.reading_errors(name, most) for name, most in largest.items()},
        of_zeros=tuple(_of_zeros(run, settings, parts, all_parts)),
        exact=tuple(name for name in settings.over.values() if name not in largest and "." in name),
    )


def _of_zeros(
    run: RunData, settings: CurveSettings, parts: Sequence[Part], all_parts: Sequence[Part]
) -> Iterator[tuple[str, ReadingError, Shares]]:
    """Yield the error of each zero that several points have, or a requested y.

    Of one point alone it is part of the scatter about the curve.
    """
    for channel in dict.fromkeys((settings.of, *settings.over.values())):
        if channel == settings.of and settings.statistic == "range":
            continue
        zeroed = [part for part in all_parts if channel in part.zeros]
        one_of = alike([part.zeros[channel] for part in zeroed])
        zero_of = {id(part): zero for part, zero in zip(zeroed, one_of, strict=True)}
        zeros = [zero_of[id(part)] for part in parts if id(part) in zero_of]
        zeros_of_requested = [
            [zero_of[id(part)] for part in zeroed if is_at(result.where, part.place)]
            if result.where and channel == settings.of
            else []
            for result in settings.results.x_at
        ]
        for zero in dict.fromkeys([*zeros, *chain(*zeros_of_requested)]):
            error = run.zero_error(channel, zero)
            shares = [
                group.count(zero) / len(group) if group else 0.0 for group in zeros_of_requested
            ]
            if error is not None and (zeros.count(zero) > 1 or any(shares)):
                has_it = np.array([float(zero_of.get(id(part)) == zero) for part in parts])
                affected = Shares(has_it, np.array(shares))
                yield channel, error, affected


def origin_of(settings: CurveSettings, units: Sequence[str]) -> float:
    """Return the origin of x in its SI unit; several x have none, and so 0."""
    if len(units) > 1:
        return 0.0
    if settings.reference is not None:
        return settings.reference.si
    return CELSIUS if unit(units[0]).dimension == "temperature" else 0.0


def _divisor(unit_text: str) -> str:
    """Return a unit in parentheses where needed, so that it can be a divisor: V/(N·m)."""
    return f"({unit_text})" if "·" in unit_text else unit_text


def _requested_y(settings: CurveSettings, parts: Sequence[Part]) -> tuple[Array, tuple[int, ...]]:
    requested_y, counts = [], []
    for result in settings.results.x_at:
        if result.y is not None:
            requested_y.append(result.y.si)
            counts.append(result.readings or 0)
            continue
        readings = [
            _statistic(part, settings.of, settings.statistic)
            for part in parts
            if is_at(result.where, part.place)
        ]
        requested_y.append(float(np.mean(readings)) if readings else nan)
        counts.append(len(readings))
    return np.array(requested_y), tuple(counts)


def _x(part: Part, source: str, statistic: str) -> float:
    if source in part.values:
        return _statistic(part, source, statistic)
    return set_value(part, source)


def _unit(part: Part, source: str) -> str:
    if source in part.values:
        return part.units[source]
    return set_unit(part, source)


def _shown(part: Part, source: str) -> str:
    """Return the unit for display: the written one, or the SI unit; a temperature in °C."""
    if source not in part.values:
        return coordinate_of(part, source).unit or "1"
    written = part.written_in.get(channel_of(source), "")
    si = part.units[source]
    return written or ("°C" if unit(si).dimension == "temperature" else si)


def _series(part: Part, name: str) -> Series:
    values = part.values[name]
    times_s = part.step_s * np.arange(len(values), dtype=np.float64)
    return Series(values, times_s, part.step_s > 0, part.step_s)


def _statistic(part: Part, name: str, statistic: str) -> float:
    return STATISTICS[statistic].value(_series(part, name))


def _scatter_of_x(run: RunData, parts: Sequence[Part], settings: CurveSettings) -> Array | None:
    names = list(settings.over.values())
    if len(names) > 1 or names[0] not in parts[0].values:
        return None
    return _scatter(run, parts, names[0], settings)[0]


def _scatter(
    run: RunData, parts: Sequence[Part], channel: str, settings: CurveSettings
) -> tuple[Array | None, Array | None]:
    """Return u of each value from the scatter in its recording, and its dof; None without.

    With that of a zero which it has alone.
    """
    scatters = [STATISTICS[settings.statistic].scatter(_series(part, channel)) for part in parts]
    known_scatters = [scatter for scatter in scatters if scatter is not None]
    if len(known_scatters) < len(parts):
        return None, None
    u, dof = np.array(known_scatters).T
    if any(channel not in part.zeros for part in parts):
        return u, dof
    zeros = alike([part.zeros[channel] for part in parts])
    for i, zero in enumerate(zeros):
        error = run.zero_error(channel, zero) if zeros.count(zero) == 1 else None
        if error is not None:
            total = hypot(u[i], error.u)  # Welch and Satterthwaite (GUM G.4.1)
            u[i], dof[i] = total, total**4 / (u[i] ** 4 / dof[i] + error.u**4 / error.dof)
    return u, dof
