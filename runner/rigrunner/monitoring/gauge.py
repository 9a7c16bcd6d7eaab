"""A gauge study of the sessions that an archive holds: each of one part by one operator."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import product
from statistics import median
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.studies import Excluded, GaugeStudy
from rigrunner.archive.querying import rows
from rigrunner.archive.rows import FOLDER
from rigrunner.monitoring.observing import TORQUE_UNIT, unfit
from rigrunner.monitoring.quantities import RESULTS
from rigrunner.trends.gauge_rr import gauge_rr

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.archive.database import Database
    from rigrunner.archive.filters import Filters
    from rigrunner.monitoring.quantities import Quantity

_FEWEST = 2
"""Parts, operators and trials."""
_NAMED = 6
"""Cells that are named before the rest is counted."""
Cell = tuple[str, str]


@dataclass
class Sessions:
    """The readings of each part by each operator, in the order of time."""

    cells: dict[Cell, list[float]] = field(default_factory=dict)
    expanded: list[float] = field(default_factory=list)
    kinds: Counter[str] = field(default_factory=Counter)
    frequencies: set[float] = field(default_factory=set)
    excluded: list[Excluded] = field(default_factory=list)


def sessions(archive: Database, quantity: Quantity, filters: Filters) -> Sessions:
    """Return the readings of the runs that fit: each set-point of a run is a trial."""
    value, expanded = RESULTS[quantity.name]
    points: dict[str, list[dict[str, Any]]] = {}
    for row in rows(archive, "points", filters):
        points.setdefault(row[FOLDER], []).append(row)
    found = Sessions()
    for run in rows(archive, "runs", filters):
        trials = points.get(run[FOLDER], [])
        reason = unfit(run) or _unclear(run, [each[value] for each in trials])
        if reason:
            found.excluded.append(Excluded(run["run_id"] or run["path"], reason))
            continue
        cell = (run["specimen"], run["operator"])
        found.cells.setdefault(cell, []).extend(each[value] for each in trials)
        found.expanded += [each[expanded] for each in trials if expanded and each[expanded]]
        found.kinds[f"{run['procedure']} by {run['method']} on {run['rig']}"] += 1
        found.frequencies |= {each["set_frequency_hz"] for each in trials}
    return found


def gauge_study(
    quantity: Quantity,
    found: Sessions,
    asked: Mapping[str, str],
    tolerance: float | None = None,
) -> GaugeStudy:
    """Return the study; raise DataError unless it is crossed and balanced, naming what is missing.

    Raises UsageError where what was found is of several kinds.
    """
    _check_alike(found)
    parts, operators = (tuple(sorted(set(each))) for each in zip(*found.cells, strict=True))
    _check_crossed(found.cells, parts, operators)
    readings = tuple(tuple(tuple(found.cells[part, by]) for by in operators) for part in parts)
    return GaugeStudy(
        quantity=quantity.name,
        unit=TORQUE_UNIT,
        asked=asked,
        excluded=tuple(found.excluded),
        parts=parts,
        operators=operators,
        readings=readings,
        analysis=gauge_rr(readings),
        tolerance=tolerance,
        expanded=median(found.expanded) if found.expanded else None,
    )


def _unclear(run: Mapping[str, Any], trials: list[float | None]) -> str:
    missing = [name for name in ("specimen", "operator") if not run[name]]
    if missing:
        return f"it says no {' and no '.join(missing)}"
    if not trials:
        return "it has no set-point that fits"
    return f"{trials.count(None)} of {len(trials)} trials have no value" if None in trials else ""


def _check_alike(found: Sessions) -> None:
    if not found.cells:
        reasons = Counter(each.reason for each in found.excluded).most_common(_NAMED)
        told = "; ".join(f"{count} left out: {reason}" for reason, count in reasons)
        raise DataError(
            f"there is no session of a gauge study: {told or 'no run fits'}",
            hint="the procedure gauge_rr makes them",
        )
    if len(found.kinds) > 1:
        kinds = ", ".join(f"{name} ({count})" for name, count in sorted(found.kinds.items()))
        raise UsageError(
            f"results of several kinds: {kinds}", hint="choose by --procedure or --rig"
        )
    if len(found.frequencies) > 1:
        shown = ", ".join(f"{each:g} Hz" for each in sorted(found.frequencies))
        raise UsageError(f"readings at several set-points: {shown}", hint="choose by --frequency")


def _check_crossed(
    cells: Mapping[Cell, list[float]], parts: tuple[str, ...], operators: tuple[str, ...]
) -> None:
    """Demand that every operator measured every part, equally often."""
    if len(parts) < _FEWEST or len(operators) < _FEWEST:
        raise DataError(
            f"{_count(parts, 'part')} and {_count(operators, 'operator')} are no crossed study",
            hint="at least 2 of each; 10 parts and 3 operators are usual",
        )
    every = product(parts, operators)
    missing = [f"{part} by {by}" for part, by in every if (part, by) not in cells]
    if missing:
        raise DataError(
            f"the study is not crossed: {_listed(missing)} {'is' if len(missing) == 1 else 'are'} "
            "missing",
            hint="measure what is missing, or leave out the part or the operator",
        )
    trials = Counter(len(each) for each in cells.values())
    usual = trials.most_common(1)[0][0]
    counts = {f"{part} by {by}": len(each) for (part, by), each in cells.items()}
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
