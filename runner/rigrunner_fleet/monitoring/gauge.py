"""A gauge study of sessions in an archive, each of one part by one operator."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import product
from statistics import median
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.studies import Excluded, GaugeStudy
from rigrunner_fleet.archive.querying import rows
from rigrunner_fleet.archive.rows import FOLDER
from rigrunner_fleet.monitoring.observing import (
    RunValue,
    coordinate_of,
    named_values,
    why_excluded,
)
from rigrunner_fleet.monitoring.quantities import TORQUE_UNIT, TORQUES, of_name, quantity_in
from rigrunner_fleet.trends.gauge_rr import gauge_rr

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner_fleet.archive.database import Database
    from rigrunner_fleet.archive.filters import Filters
    from rigrunner_fleet.monitoring.quantities import Quantity

_FEWEST = 2
"""The fewest parts, operators and trials."""
_NAMED = 6
"""Cells that are named; the rest is counted."""
Cell = tuple[str, str]


@dataclass
class Sessions:
    """The readings of each part by each operator, in the order of time."""

    quantity: Quantity
    unit: str = TORQUE_UNIT
    cells: dict[Cell, list[float]] = field(default_factory=dict)
    expanded: list[float] = field(default_factory=list)
    kinds: Counter[str] = field(default_factory=Counter)
    places: set[str] = field(default_factory=set)
    """The set-points of the readings, as text."""
    excluded: list[Excluded] = field(default_factory=list)


def read_sessions(archive: Database, name: str, filters: Filters) -> Sessions:
    """Return the readings of the selected runs.

    Each set-point of a run is a trial; for a named result each of its values, such as over a
    counter.
    """
    quantity = quantity_in(archive, name, filters)
    if quantity.is_named:
        filters = of_name(name, filters)
        readings = named_values(archive, filters)
    else:
        readings = _torques(archive, quantity, filters)
    sessions = Sessions(quantity)
    places = _set_points(archive, filters) if quantity.is_named else {}
    for run in rows(archive, "runs", filters):
        trials = readings.get(run[FOLDER], [])
        reason = why_excluded(run) or _why_no_trials(run, trials)
        if reason:
            sessions.excluded.append(Excluded(run["run_id"] or run["path"], reason))
            continue
        cell = (run["specimen"], run["operator"])
        values = [trial.value for trial in trials if trial.value is not None]
        sessions.cells.setdefault(cell, []).extend(values)
        sessions.expanded += [trial.expanded for trial in trials if trial.expanded]
        method = f" by {run['method']}" if run["method"] else ""
        sessions.kinds[f"{run['procedure']}{method} on {run['rig']}"] += 1
        sessions.places |= {
            places.get((run[FOLDER], trial.number), "") if quantity.is_named else trial.place
            for trial in trials
        }
        sessions.unit = trials[0].unit
    return sessions


def _torques(archive: Database, quantity: Quantity, filters: Filters) -> dict[str, list[RunValue]]:
    """Return the torque, or the raw peak, at each set-point of each run."""
    if quantity.name not in TORQUES:
        hint = f"there are {', '.join(TORQUES)}, and named results"
        raise UsageError(f"no matching run has a result '{quantity.name}'", hint=hint)
    value, expanded = TORQUES[quantity.name]
    values: dict[str, list[RunValue]] = {}
    for row in rows(archive, "points", filters):
        place = f"{row['set_frequency_hz']:g} Hz"
        entry = RunValue(row[value], row[expanded] if expanded else None, TORQUE_UNIT, place)
        values.setdefault(row[FOLDER], []).append(entry)
    return values


def _set_points(archive: Database, filters: Filters) -> dict[tuple[str, int], str]:
    """Return the set-points of each named result by run and number: 'role.name = 100 °C'.

    Equal ones have equal texts, also where runs state them in different units.
    """
    set_points: dict[tuple[str, int], str] = {}
    shown: dict[tuple[Any, ...], str] = {}
    for row in rows(archive, "coordinates", filters):
        if row["name"] != row["short"]:
            key = row[FOLDER], row["number"]
            previous = [set_points[key]] if key in set_points else []
            text = shown.setdefault(coordinate_of(row), f"{row['name']} = {row['text']}")
            set_points[key] = ", ".join([*previous, text])
    return set_points


def gauge_study(
    sessions: Sessions,
    asked: Mapping[str, str],
    tolerance: float | None = None,
) -> GaugeStudy:
    """Return the study; raise DataError, naming what is missing, unless it is crossed and balanced.

    Raises UsageError if the readings are of several kinds.
    """
    _check_alike(sessions)
    parts, operators = (tuple(sorted(set(names))) for names in zip(*sessions.cells, strict=True))
    _check_crossed(sessions.cells, parts, operators)
    cells = sessions.cells
    readings = tuple(
        tuple(tuple(cells[part, operator]) for operator in operators) for part in parts
    )
    return GaugeStudy(
        quantity=sessions.quantity.name,
        unit=sessions.unit,
        asked=asked,
        excluded=tuple(sessions.excluded),
        parts=parts,
        operators=operators,
        readings=readings,
        analysis=gauge_rr(readings),
        tolerance=tolerance,
        expanded=median(sessions.expanded) if sessions.expanded else None,
    )


def _why_no_trials(run: Mapping[str, Any], trials: Sequence[RunValue]) -> str:
    missing = [name for name in ("specimen", "operator") if not run[name]]
    if missing:
        return f"it has no {' and no '.join(missing)}"
    if not trials:
        return "it has no matching set-point"
    empty = sum(1 for trial in trials if trial.value is None)
    return f"{empty} of {len(trials)} trials have no value" if empty else ""


def _check_alike(sessions: Sessions) -> None:
    if not sessions.cells:
        reasons = Counter(run.reason for run in sessions.excluded).most_common(_NAMED)
        left_out = "; ".join(f"{count} left out: {reason}" for reason, count in reasons)
        raise DataError(
            f"there is no session of a gauge study: {left_out or 'no matching run'}",
            hint="the procedure gauge_rr makes them",
        )
    if len(sessions.kinds) > 1:
        kinds = ", ".join(f"{name} ({count})" for name, count in sorted(sessions.kinds.items()))
        raise UsageError(
            f"results of several kinds: {kinds}", hint="choose by --procedure or --rig"
        )
    if len(sessions.places) > 1:
        shown = ", ".join(sorted(sessions.places))
        option = "--where" if sessions.quantity.is_named else "--frequency"
        raise UsageError(f"readings at several set-points: {shown}", hint=f"choose by {option}")


def _check_crossed(
    cells: Mapping[Cell, list[float]], parts: tuple[str, ...], operators: tuple[str, ...]
) -> None:
    """Raise unless every operator measured every part equally often."""
    if len(parts) < _FEWEST or len(operators) < _FEWEST:
        raise DataError(
            f"{_count(parts, 'part')} and {_count(operators, 'operator')} are not a crossed study",
            hint="at least 2 of each; 10 parts and 3 operators are usual",
        )
    pairs = product(parts, operators)
    missing = [f"{part} by {operator}" for part, operator in pairs if (part, operator) not in cells]
    if missing:
        raise DataError(
            f"the study is not crossed: {_listed(missing)} {'is' if len(missing) == 1 else 'are'} "
            "missing",
            hint="measure what is missing, or leave out the part or the operator",
        )
    trials = Counter(len(readings) for readings in cells.values())
    usual = trials.most_common(1)[0][0]
    counts = {f"{part} by {operator}": len(cell) for (part, operator), cell in cells.items()}
    odd = [f"{name} has {count}" for name, count in counts.items() if count != usual]
    if odd:
        raise DataError(
            f"the study is not balanced: most have {usual} trials, {_listed(odd)}",
            hint="--since and --until leave out sessions that are not of this study",
        )
    if usual < _FEWEST:
        raise DataError("there is 1 trial of each: repeatability needs 2 or more")


def _listed(names: list[str]) -> str:
    more = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {more} more" if more > 0 else "")


def _count(names: tuple[str, ...], word: str) -> str:
    return f"{len(names)} {word}" + ("" if len(names) == 1 else "s")
