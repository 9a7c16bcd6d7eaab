"""Which partner runs the analyses of a procedure ask for, known from its settings alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.analysis.requirements import LATEST, STATION
from rigrunner.api.errors import PluginError
from rigrunner.api.units import unit
from rigrunner.plan.measured import measured_places
from rigrunner.yamlfile.problems import Problems, suggestion

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.analysis import Requirements
    from rigrunner.api.analysis.requirements import NeededRun
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.plan.actions import Plan
    from rigrunner.procedure import AnalysisRef, LoadedProcedure, Procedure
    from rigrunner.registry import Registry
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile.document import Path

Value = float | str
"""Of a set-point, counter or label, in the SI unit."""


@dataclass(frozen=True)
class AskedRun:
    """A partner run that one analysis asks for."""

    needed: NeededRun
    path: Path
    """Where the procedure asks for it."""
    values: tuple[Mapping[str, CoordinateValue], ...] = ()
    """The places of this run, in the coordinates of `needed.at`, as far as they are known."""


def asked_runs(
    procedure: Procedure, registry: Registry, plan: Plan | None = None
) -> tuple[AskedRun, ...]:
    """Return all partner runs that a procedure asks for, one for each analysis that does.

    Without a plan nothing is known of the places of this run. A plugin that is not there asks for
    none: the check of the plugins reports it.
    """
    asked = []
    for path, plugin in procedure.analyses_at:
        try:
            needs = registry.requires(plugin.kind, plugin.name, plugin.settings)
        except PluginError:
            continue
        for needed in needs.partners:
            values = () if plan is None else _places(plan, plugin, needs, needed)
            asked.append(AskedRun(needed, (*path, *needed.key), values))
    return tuple(asked)


def check_partners(procedure: LoadedProcedure, station: LoadedStation, registry: Registry) -> None:
    """Raise InvalidFileError where a requirement for partner runs can never be met."""
    problems, document = Problems(), procedure.document
    first_asked: dict[str, NeededRun] = {}
    for asked in asked_runs(procedure.model, registry):
        needed = asked.needed
        if not needed.procedure and needed.run == LATEST:
            hint = "write the id of the procedure of which it must be a run"
            problems.add(document, asked.path, "the key 'procedure' is missing", hint, key=True)
        first = first_asked.setdefault(needed.name, needed)
        if _identity(first) != _identity(needed):
            message = f"analyses ask for different runs by the name '{needed.name}'"
            problems.add(document, asked.path, message, "give one another name", key=True)
        _check_common(asked, procedure, station, registry, problems)
    problems.stop_if_any()


def _identity(needed: NeededRun) -> tuple[object, ...]:
    return (needed.procedure, needed.run, needed.max_age_s, set(needed.same), needed.after)


def _check_common(
    asked: AskedRun,
    procedure: LoadedProcedure,
    station: LoadedStation,
    registry: Registry,
    problems: Problems,
) -> None:
    """Add a problem for what both runs must have in common, and is not known of the rig."""
    fields = registry.rig_model().model_fields
    for index, key in enumerate(asked.needed.same):
        if key == STATION:
            continue
        if key not in fields:
            keys = [STATION, *fields]
            message = f"a rig has no key '{key}'"
            hint = suggestion(key, keys, "there are")
            problems.add(procedure.document, (*asked.path, "same", index), message, hint)
        elif station.model.rig.get(key) in (None, ""):
            message = f"the analysis needs the key '{key}' of the rig, which is missing"
            hint = f"it is needed at {procedure.document.where(asked.path, key=True)}"
            problems.add(station.document, ("rig", key), message, hint, key=True)


def _places(
    plan: Plan, plugin: AnalysisRef, needs: Requirements, needed: NeededRun
) -> tuple[Mapping[str, CoordinateValue], ...]:
    """Return the different places of an analysis, in those coordinates that are known before."""
    places: dict[tuple[object, ...], Mapping[str, CoordinateValue]] = {}
    for place in measured_places(plan, plugin.settings, needs.channels):
        values = {name: place[name] for name in needed.at if name in place}
        if len(values) == len(needed.at) > 0:
            places.setdefault(tuple(value.usual for value in values.values()), values)
    return tuple(places.values())


def in_si(coordinate: CoordinateValue) -> Value:
    """Return the value of a coordinate in the SI unit."""
    if isinstance(coordinate.value, str):
        return coordinate.value
    return unit(coordinate.unit or "1").to_si(coordinate.value)
