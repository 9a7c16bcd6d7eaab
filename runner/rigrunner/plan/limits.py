"""Whether the limits of a procedure are limits of what it measures, asked before the run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rigrunner.api.errors import PluginError
from rigrunner.api.quantity import unit
from rigrunner.plan.actions import Measure, Record
from rigrunner.plan.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.measurand import MeasurandKind
    from rigrunner.plan.actions import Plan
    from rigrunner.procedure import Limit, LoadedProcedure
    from rigrunner.yamlfile.document import Path


class MeasurandLookup(Protocol):
    """Knows which torque each compensation yields."""

    def yields(self, compensation: str) -> MeasurandKind | None:
        """Return it, or None where the plugin does not say; raise PluginError for an unknown."""
        ...


def check_limits(procedure: LoadedProcedure, plan: Plan | None, lookup: MeasurandLookup) -> None:
    """Raise InvalidFileError with every limit of another torque than the one that is measured.

    Without a plan the loads and frequencies are not known, and not checked.
    """
    problems = Problems()
    _check_measurands(procedure, plan, lookup, problems)
    if plan is not None:
        _check_frequencies(procedure, plan, problems)
    problems.stop_if_any()


def _check_measurands(
    procedure: LoadedProcedure, plan: Plan | None, lookup: MeasurandLookup, problems: Problems
) -> None:
    spec = procedure.model.analysis
    primary = spec.primary_plugin
    if primary is None:
        return
    try:
        kind = lookup.yields(primary.name)
    except PluginError:
        return
    for path, limit in _limits(procedure):
        place: Path = (*path, "measurand")
        if kind is None:
            message = f"'{primary.name}' does not say which torque it yields"
            hint = "its plugin must declare it ('yields'), or the limit be left out"
            problems.add(procedure.document, place, message, hint)
            continue
        objection = limit.measurand.objection(spec.measured(kind), _loads(procedure, plan))
        if objection:
            hint = "limits and results of two measurands have nothing to say to each other"
            problems.add(procedure.document, place, objection, hint)


def _check_frequencies(procedure: LoadedProcedure, plan: Plan, problems: Problems) -> None:
    """Add a problem for every named frequency at which nothing is recorded."""
    if any(isinstance(step.action, Measure) for step in plan.steps):
        return
    there = sorted({hz for record in _records(plan) for hz in _frequencies(record)})
    for path, limit in _limits(procedure):
        missing = limit.missing(there)
        if missing:
            message = f"nothing is recorded at {', '.join(f'{hz:g} Hz' for hz in missing)}"
            hint = f"recorded: {', '.join(f'{hz:g} Hz' for hz in there) or 'nothing'}"
            problems.add(procedure.document, (*path, "at"), message, hint)


def _limits(procedure: LoadedProcedure) -> Iterator[tuple[Path, Limit]]:
    acceptance = procedure.model.acceptance
    if acceptance is None:
        return
    if acceptance.limit is not None:
        yield ("acceptance", "limit"), acceptance.limit
    for index, limit in enumerate(acceptance.limits):
        yield ("acceptance", "limits", index), limit


def _records(plan: Plan) -> Iterator[Record]:
    for step in plan.steps:
        if isinstance(step.action, Record):
            yield step.action


def _loads(procedure: LoadedProcedure, plan: Plan | None) -> list[float]:
    """Return the set loads of what is judged, as far as the procedure sets them, in N."""
    if plan is None:
        return []
    no_load = procedure.model.analysis.no_load
    loads = [record.setpoints.get(f"{record.role}.load") for record in _records(plan)]
    known = [load for load in loads if load is not None]
    return [load for load in known if load > 0] if no_load and no_load.is_this_run else known


def _frequencies(record: Record) -> Iterator[float]:
    for name, value in record.setpoints.items():
        if unit(record.units[name]).dimension == "frequency":
            yield value
