"""Whether the limits of a procedure are limits of what it measures, asked before the run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.member import Member
from rigrunner.api.places import matches
from rigrunner.api.units import unit
from rigrunner.plan.selection import analysed
from rigrunner.procedure import FREQUENCY
from rigrunner.procedure.limits import add_other_measurands, torque_limits
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.plan.actions import Plan, Recording
    from rigrunner.procedure import LoadedProcedure, MeasurandLookup


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
