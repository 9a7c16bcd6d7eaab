"""Whether the limits of a procedure are limits of what it measures, asked before the run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.errors import DataError
from rigrunner.api.member import Member
from rigrunner.api.places import matches
from rigrunner.api.units import unit, with_article
from rigrunner.plan.selection import analysed
from rigrunner.procedure import FREQUENCY
from rigrunner.procedure.limits import add_other_measurands, torque_limits
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.findings import ResultDefinition
    from rigrunner.plan.actions import Plan, Recording
    from rigrunner.procedure import Limit, LoadedProcedure, MeasurandLookup


class Place(Protocol):
    """Where a recording or row will be made."""

    @property
    def coordinate_units(self) -> Mapping[str, str]:
        """Of its set-points and coordinates; '' of one that has none."""
        ...

    @property
    def place(self) -> Mapping[str, CoordinateValue]:
        """The values of these, as far as they are known beforehand."""
        ...


Objection = tuple[tuple[str | int, ...], str, str]
"""Where it stands in the limit, a message and a hint."""


def check_limits(procedure: LoadedProcedure, plan: Plan | None, lookup: MeasurandLookup) -> None:
    """Raise InvalidFileError with every limit of another torque than the one that is measured.

    Without a plan the loads and frequencies are not known, and not checked.
    """
    problems = Problems()
    plan = plan and analysed(plan, procedure)
    add_other_measurands(problems, procedure, lookup, _loads(procedure, plan))
    if plan is not None:
        _check_frequencies(procedure, plan, problems)
    problems.stop_if_any()


def _check_frequencies(procedure: LoadedProcedure, plan: Plan, problems: Problems) -> None:
    """Add a problem for every named frequency at which nothing is recorded."""
    if any(step.action.rows for step in plan.steps):
        return
    there = sorted({hz for each in plan.recordings for hz in _frequencies(each.record)})
    known = [CoordinateValue(hz, "Hz") for hz in there]
    for path, limit in torque_limits(procedure):
        wanted = limit.where.get(FREQUENCY, ())
        missing = [each for each in wanted if not any(matches(each, hz) for hz in known)]
        if missing:
            message = f"nothing is recorded at {', '.join(map(str, missing))}"
            hint = f"recorded: {', '.join(map(str, known)) or 'nothing'}"
            problems.add(procedure.document, (*path, "where", FREQUENCY), message, hint)


def _loads(procedure: LoadedProcedure, plan: Plan | None) -> list[float]:
    """Return the set loads of what is judged, as far as the procedure sets them, in N."""
    if plan is None:
        return []
    no_load = procedure.model.torque_analysis.no_load
    records = [each.record for each in plan.recordings]
    loads = [each.setpoints.get(Member(each.role, "load")) for each in records]
    known = [load for load in loads if load is not None]
    return [load for load in known if load > 0] if no_load and no_load.is_this_run else known


def _frequencies(record: Recording) -> Iterator[float]:
    for name, value in record.setpoints.items():
        if unit(record.units[name]).dimension == "frequency":
            yield value


def objections_to_limit(
    limit: Limit, of: ResultDefinition, places: Sequence[Place]
) -> Iterator[Objection]:
    """Yield why a limit cannot be held against its result at the places where that is measured."""
    fits = True
    for key, name, given in limit.of_coordinates():
        symbol = next((each.coordinate_units[name] for each in places
                       if name in each.coordinate_units), None)  # fmt: skip
        if symbol is None or name not in of.per:
            return  # reported by the check of the coordinates
        kind = unit(symbol or "1").dimension
        if given.dimension != kind:
            message = f"got '{given}', {with_article(given.dimension)}"
            yield key, f"{message}; {name} is {with_article(kind)}", f"write it in {symbol}"
            fits = False
    if fits:
        yield from _of_places(limit, of, [each.place for each in places])


def _of_places(
    limit: Limit, of: ResultDefinition, places: Sequence[Mapping[str, CoordinateValue]]
) -> Iterator[Objection]:
    """Yield where it names a place at which nothing is measured, or has no value at one that is."""
    for name, wanted in limit.where.items():
        known = [each[name] for each in places if name in each]
        missing = [each for each in wanted if not any(matches(each, at) for at in known)]
        if missing and len(known) == len(places):
            hint = f"there are: {', '.join(dict.fromkeys(map(str, known)))}"
            message = f"{of.name} is not measured at {', '.join(map(str, missing))}"
            yield ("where", name), message, hint
    for at in places:
        if limit.follows <= at.keys() and set(of.per) <= at.keys() and limit.is_of(at):
            try:
                limit.limits_at(at, of.unit)
            except DataError as error:
                ends = [key for key, end in limit.ends.items() if hasattr(end, "over")]
                yield tuple(ends[:1]), error.message, error.hint
                return
