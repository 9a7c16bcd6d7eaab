"""The values of a quantity in an archive, by group of runs, and the excluded runs."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from math import floor, inf, isfinite, log10, ulp
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.studies import Excluded, Observed
from rigrunner.api.units import from_si, unit
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_fleet.archive.querying import rows
from rigrunner_fleet.archive.rows import FOLDER
from rigrunner_fleet.monitoring.quantities import TORQUE_UNIT, TORQUES, of_name, quantity_in

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigrunner_fleet.archive.database import Database
    from rigrunner_fleet.archive.filters import Filters
    from rigrunner_fleet.monitoring.quantities import Quantity


Bounds = tuple[float | None, float | None]
"""A lower and an upper limit; None for a missing one."""
NOT_STATED = "not stated"
_UNIT = re.compile(r"([\w.-]+) = [+-]?\d[\d.]*(?:e[+-]?\d+)?(.*?)(?:, |$)")
"""Name and unit of a coordinate that is a number, in the text of a place."""
_OF_POINTS = ("frequency", "load")
_APART = "separate them: --by rig --by mandrel"


@dataclass(frozen=True)
class RunValue:
    """A value of a run with its unit; the run may turn out to be excluded."""

    value: float | None
    expanded: float | None
    unit: str
    place: str = ""
    """The coordinates of a named result."""
    number: int = 0
    """The number of a named result or a set-point in its run."""
    limits: Bounds = (None, None)
    """The lower and the upper limit of a named result in its run."""


@dataclass
class Group:
    """The values of some runs, oldest first, and what they must have in common."""

    observed: list[Observed] = field(default_factory=list)
    kinds: Counter[str] = field(default_factory=Counter)
    limits: Counter[Bounds] = field(default_factory=Counter)
    """The number of values by their limits in their runs."""


@dataclass(frozen=True)
class Observations:
    """The values of each group of runs, and remarks on them."""

    quantity: Quantity
    by: Sequence[str]
    """The columns of runs by which they are grouped."""
    unit: str
    groups: Mapping[str, Group]
    excluded: tuple[Excluded, ...]
    warnings: tuple[str, ...]


def observe(
    archive: Database,
    name: str,
    filters: Filters,
    by: Sequence[str] = (),
) -> Observations:
    """Return the values of a quantity in the selected runs; by the columns of runs in `by`.

    A named result is also grouped by its coordinates, if it has several. A run that was not
    completed, cannot be read, is gone, was replayed from a tape or has no such value is excluded
    and named; so is one whose figure is that of a no-load run already counted. Raises DataError if
    nothing is left, and UsageError if several figures match.
    """
    quantity = quantity_in(archive, name, filters)
    if quantity.is_named:
        filters = of_name(name, filters)
    by = by or quantity.groups
    values = _values(archive, quantity, filters)
    places = {entry.place for entries in values.values() for entry in entries}
    groups: dict[str, Group] = {}
    excluded, simulated, counted, doubtful = [], set(), 0, 0
    figures: dict[tuple[str, float | None], str] = {}
    for run in rows(archive, "runs", filters):
        run_id = run["run_id"] or run["path"]
        entries = values.get(run[FOLDER], [])
        reason = why_excluded(run) or _why_no_value(entries, quantity)
        if not (reason or quantity.is_result):
            # The figure of a no-load run is there again in each run that uses it.
            key = (run["no_load_run"] or run["run_id"], entries[0].value)
            first = figures.setdefault(key, run["run_id"])
            if first != run["run_id"]:
                reason = f"its value is that of {first}: the same no-load run"
        if reason:
            excluded.append(Excluded(run_id, reason))
            continue
        counted += 1
        simulated.add(bool(run["simulated"]))
        doubtful += bool(run["failed_checks"])
        empty = [entry.place for entry in entries if entry.value is None]
        excluded += [Excluded(run_id, f"it has no value at {place}") for place in empty]
        for value, entry in [(entry.value, entry) for entry in entries if entry.value is not None]:
            group_name = [_name(run, by), entry.place] if len(places) > 1 else [_name(run, by)]
            group = groups.setdefault(", ".join(filter(None, group_name)), Group())
            group.observed.append(Observed(run_id, run["started_utc"], value, entry.expanded))
            group.kinds[_kind(run, quantity)] += 1
            group.limits[entry.limits] += 1
    if not groups:
        raise DataError(_no_value(quantity, excluded), hint="'rigrunner archive search' shows runs")
    units = {entry.unit for entries in values.values() for entry in entries}
    warnings = []
    if len(simulated) > 1:
        warnings.append("the runs include simulated ones: --real leaves them out")
    if doubtful:
        warnings.append(f"{doubtful} of {counted} runs did not pass all checks of the analysis")
    shown = " or ".join(sorted(units))
    return Observations(quantity, by, shown, groups, tuple(excluded), tuple(warnings))


def _check_one_kind(group: Group, quantity: Quantity) -> None:
    """Raise DataError if values of a group cannot be compared with each other."""
    if len(group.kinds) < 2:  # noqa: PLR2004  (of one kind, all can be compared)
        return
    kinds = ", ".join(f"{name} ({count})" for name, count in sorted(group.kinds.items()))
    if quantity.is_result:
        message = f"results of several procedures or methods: {kinds}; group them by procedure"
        raise DataError(message, hint="choose by --procedure")
    raise DataError(f"figures of several rigs or mandrels: {kinds}", hint=_APART)


def _values(archive: Database, quantity: Quantity, filters: Filters) -> dict[str, list[RunValue]]:
    if quantity.is_named:
        return named_values(archive, filters)
    if not quantity.is_result:
        return _figures(archive, quantity, filters)
    at_points = any(name in filters.ranges for name in _OF_POINTS)
    value, expanded = TORQUES[quantity.name]
    values: dict[str, list[RunValue]] = {}
    for row in rows(archive, "points" if at_points else "runs", filters):
        if row[value] is not None:
            torque = RunValue(row[value], row[expanded] if expanded else None, TORQUE_UNIT)
            values.setdefault(row[FOLDER], []).append(torque)
    return values


def named_values(archive: Database, filters: Filters) -> dict[str, list[RunValue]]:
    """Return the named results of each run, in the unit of the newest."""
    results = [row for row in rows(archive, "results", filters) if row["si_unit"]]
    kinds = sorted({row["si_unit"] for row in results})
    if len(kinds) > 1:
        hint = "choose by --procedure or --revision"
        raise UsageError(f"'{results[0]['name']}' is in {' and in '.join(kinds)}", hint=hint)
    values: dict[str, list[RunValue]] = {}
    places = _places(archive, filters, results)
    for row in results:
        value = _in_unit(row, results[-1]["unit"], places[row["place"]])
        values.setdefault(row[FOLDER], []).append(value)
    return values


def _places(
    archive: Database, filters: Filters, results: Sequence[Mapping[str, Any]]
) -> dict[str | None, str]:
    """Return each place of results, by its text, as the newest run states it.

    Runs may state one place in different units: their coordinates are compared then.
    """
    newest: dict[str | None, Mapping[str, Any]] = {}
    for row in reversed(results):  # the oldest run is first
        newest.setdefault(row["place"], row)
    units = {unit for place in newest for unit in _UNIT.findall(place or "")}
    if len({name for name, _ in units}) == len(units):
        return {place: place or "" for place in newest}
    at: dict[tuple[str, int], set[tuple[Any, ...]]] = {}
    for row in rows(archive, "coordinates", filters):
        at.setdefault((row[FOLDER], row["number"]), set()).add(coordinate_of(row))
    shown: dict[frozenset[tuple[Any, ...]], str] = {}
    places: dict[str | None, str] = {}
    for place, row in newest.items():
        coordinates = frozenset(at.get((row[FOLDER], row["number"]), ()))
        places[place] = shown.setdefault(coordinates, place or "")
    return places


def coordinate_of(row: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return name and value of a coordinate of an archive: equal ones are the same."""
    return row["name"], row["text"] if row["value"] is None else row["value"], row["unit"]


def _in_unit(row: Mapping[str, Any], symbol: str, place: str) -> RunValue:
    """Return a named result in another unit of the same kind; unchanged if it is its own."""
    expanded = None if row["expanded"] is None else float(row["expanded"])
    value = row["value"]
    limits = row["lower"], row["upper"]
    if row["unit"] != symbol:
        scale = unit(row["unit"]).factor / unit(symbol).factor
        value = None if value is None else _converted(row["si_value"], symbol)
        expanded = expanded and expanded * scale
        limits = (
            _converted_limit(limits[0], row["unit"], symbol),
            _converted_limit(limits[1], row["unit"], symbol),
        )
    return RunValue(value, expanded, symbol, place, row["number"], limits)


def _converted(si: float, symbol: str) -> float:
    """Return an SI value in a unit, without digits from rounding.

    25.3 °C stated in K is 25.30000000000001 °C, and equal values would seem to scatter.
    """
    target = unit(symbol)
    rounding = 4 * ulp(max(abs(si), abs(target.offset))) / target.factor
    return round(from_si(si, symbol), floor(-log10(rounding)))


def _converted_limit(value: float | None, symbol: str, target: str) -> float | None:
    """Return a limit in another unit, without digits from rounding."""
    if value is None:
        return None
    source = unit(symbol)
    return float(f"{from_si(value * source.factor + source.offset, target):.12g}")


def _figures(archive: Database, quantity: Quantity, filters: Filters) -> dict[str, list[RunValue]]:
    values: dict[str, list[RunValue]] = {}
    names, known_names, units = set(), set(), set()
    for row in rows(archive, "figures", filters):
        known_names.add(row["name"])
        if quantity.fits(row["source"], row["name"]) and row["value"] is not None:
            names.add(f"{row['source']}/{row['name']}")
            units.add(row["unit"] or "1")
            expanded = None
            if row["u"] is not None and isfinite(row["u"]):
                dof = inf if row["dof"] is None else row["dof"]
                expanded = float(row["u"] * coverage_factor(dof))
            figure = RunValue(row["value"], expanded, row["unit"] or "")
            values.setdefault(row[FOLDER], []).append(figure)
    if len(names) > 1:
        raise UsageError(
            f"several figures are called '{quantity.name}'",
            hint=f"name one: {', '.join(sorted(names))}",
        )
    if len(units) > 1:
        hint = "choose by --procedure or --revision"
        raise UsageError(f"'{quantity.name}' is in {' and in '.join(sorted(units))}", hint=hint)
    known_names |= {row["name"] for row in rows(archive, "results", filters)}
    if not values and known_names:
        raise UsageError(
            f"no matching run has a result or figure '{quantity.name}'",
            hint=f"there are: {', '.join([*TORQUES, *sorted(known_names)])}",
        )
    return values


def why_excluded(run: Mapping[str, Any]) -> str:
    """Return why a run of an archive does not count in a study; empty if it does."""
    if run["problem"]:
        return "it cannot be read"
    if run["missing"]:
        return "its files are gone"
    if run["outcome"] != "completed" or not run["sealed"]:
        return f"it was not completed: {run['outcome'] or 'not sealed'}"
    return "it is the replay of a tape" if run["replayed"] else ""


def _why_no_value(entries: Sequence[RunValue], quantity: Quantity) -> str:
    """Return why the result of a run is no value; empty if it is one, or one at each place."""
    if all(entry.value is None for entry in entries):
        return "it has no such value"
    if len(entries) > 1 and not quantity.is_named:
        return "several of its set-points match"
    finite = all(entry.value is None or isfinite(entry.value) for entry in entries)
    return "" if finite else "its value is not a finite number"


def _name(run: Mapping[str, Any], by: Sequence[str]) -> str:
    return ", ".join(f"{column} {run[column] or NOT_STATED}" for column in by) or "all runs"


def _kind(run: Mapping[str, Any], quantity: Quantity) -> str:
    if quantity.is_result:
        return " by ".join(filter(None, (run["procedure"], run["method"])))
    names = ("rig",) if quantity.is_zero else ("rig", "mandrel")
    return " with ".join(filter(None, (run[column] for column in names)))


def _no_value(quantity: Quantity, excluded: Sequence[Excluded]) -> str:
    if not excluded:
        return "no matching run"
    reasons = Counter(run.reason for run in excluded).most_common(3)
    counts = "; ".join(f"{count} x {reason}" for reason, count in reasons)
    return f"no matching run has a valid '{quantity.name}': {counts}"


_Series = TypeVar("_Series")


class NoStudyError(DataError):
    """No group has a study; `refused` has the reason of each, by its name."""

    def __init__(self, problem: str, refused: dict[str, str], hint: str) -> None:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in refused.items())
        super().__init__(f"{problem}. {reasons}", hint=hint)
        self.refused = refused


def study_groups(
    observations: Observations, study: Callable[[str, Group], _Series], problem: str
) -> tuple[tuple[_Series, ...], dict[str, str]]:
    """Return the study of each group, by its name, and the reasons of groups without one.

    Raises NoStudyError that begins with `problem` if no group has a study.
    """
    series, refused, hint = [], {}, ""

    def by(name: str) -> list[str]:
        return name.split(", ")[: len(observations.by)]

    for name in sorted(observations.groups, key=by):  # places stay in the order of the run
        group = observations.groups[name]
        try:
            _check_one_kind(group, observations.quantity)
            series.append(study(name, group))
        except DataError as error:
            refused[name], hint = error.message, error.hint
    if not series:
        raise NoStudyError(problem, refused, hint)
    return tuple(series), refused
