"""Whether the plugins that procedure and station name are there, and take their settings."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from pydantic import ValidationError

from rigrunner.api.errors import InvalidFileError, PluginError
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.api.plugin_refs import plugins_in
from rigrunner.api.settings import MadeOfOthers
from rigrunner.api.units import unit, units_of
from rigrunner.yamlfile import validate
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner.api.fit_choice import FitChoice
    from rigrunner.api.plugin_refs import PluginRef
    from rigrunner.procedure import Acceptance, LoadedProcedure
    from rigrunner.registry import Registry
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path


@dataclass(frozen=True)
class _Use:
    """A plugin that is named in a document."""

    kind: str
    name: str
    document: Document
    named_at: Path
    settings_at: Path


def check_plugins(procedure: LoadedProcedure, station: LoadedStation, registry: Registry) -> None:
    """Raise InvalidFileError with every plugin that is not there or refuses its settings."""
    problems = Problems()
    analyses = (
        _Use(plugin.kind, plugin.name, procedure.document, path, path)
        for path, plugin in procedure.model.analyses_at
    )
    plugins = [*analyses, *_uses_of_station(station)]
    uses = [used for use in plugins for used in _check(use, registry, problems)]
    _check_rig(station, uses, registry, problems)
    _check_measurand(procedure, registry, problems)
    if procedure.model.acceptance is not None:
        _check_rule(procedure.document, procedure.model.acceptance, registry, problems)
    problems.stop_if_any()


def check_rule(document: Document, acceptance: Acceptance, registry: Registry) -> None:
    """Raise InvalidFileError for a decision rule that is not there or refuses its settings."""
    problems = Problems()
    _check_rule(document, acceptance, registry, problems)
    problems.stop_if_any()


def _check_rule(
    document: Document, acceptance: Acceptance, registry: Registry, problems: Problems
) -> None:
    """Check the rule and its settings, of which `fraction` may stand beside it."""
    rule, at = acceptance.rule, ("acceptance", "rule")
    if acceptance.fraction is None:
        _check(_use(document, at, rule), registry, problems)
        return
    try:
        registry.settings_of(rule.kind, rule.name).model_validate(acceptance.rule_settings)
    except PluginError as error:
        problems.add(document, at, error.message, error.hint)
    except ValidationError as error:
        detail = error.errors()[0]
        is_unknown = detail["type"] == "extra_forbidden"
        message = f"the rule '{rule.name}' has no such setting" if is_unknown else detail["msg"]
        problems.add(document, ("acceptance", "fraction"), message)


def check_station_plugins(station: LoadedStation, registry: Registry) -> None:
    """Raise InvalidFileError with every plugin of a station that is not there or refuses."""
    problems = Problems()
    uses = [used for use in _uses_of_station(station) for used in _check(use, registry, problems)]
    _check_rig(station, uses, registry, problems)
    problems.stop_if_any()


def _check_rig(
    station: LoadedStation, uses: Iterable[_Use], registry: Registry, problems: Problems
) -> None:
    """Add a problem for each key of the rig that is wrong, or that a plugin in use needs."""
    needed: dict[str, _Use] = {}
    for use in uses:
        with suppress(PluginError):  # a missing plugin is reported elsewhere
            model = registry.rig_of(use.kind, use.name)
            fields = model.model_fields if model else {}
            needed |= {key: use for key, field in fields.items() if field.is_required()}
    try:
        validate(registry.rig_model(), station.document, ("rig",))
    except PluginError as error:
        problems.add(station.document, ("rig",), error.message, key=True)
    except InvalidFileError as error:
        for problem in error.problems:
            key = problem.field.removeprefix("rig.")
            # A missing key counts only where a plugin in use needs it; within a mapping, always.
            is_missing = problem.field != "rig" and key not in station.model.rig
            if not is_missing or "." in key:
                problems.include([problem])
            elif key in needed:
                use = needed[key]
                at = use.document.where(use.named_at, key=use.named_at == use.settings_at)
                hint = f"the {use.kind.replace('_', ' ')} '{use.name}' needs it ({at})"
                problems.include([replace(problem, hint=hint)])


def _uses_of_station(station: LoadedStation) -> Iterator[_Use]:
    for role, device in station.model.devices.items():
        named_at, settings_at = ("devices", role, "plugin"), ("devices", role, "settings")
        yield _Use("device", device.plugin, station.document, named_at, settings_at)
    for index, listener in enumerate(station.model.listeners):
        at: Path = ("listeners", index)
        yield _Use(
            "event_sink", listener.plugin, station.document, (*at, "plugin"), (*at, "settings")
        )


def _use(document: Document, path: Path, plugin: PluginRef | FitChoice) -> _Use:
    settings_at: Path = (*path, plugin.name)
    named_at = settings_at if isinstance(document.part(path), dict) else path
    return _Use(plugin.kind, plugin.name, document, named_at, settings_at)


def _check(use: _Use, registry: Registry, problems: Problems) -> list[_Use]:
    """Add what is wrong with a plugin's settings; return it, and the plugins that they name."""
    used = [use]
    try:
        model = registry.settings_of(use.kind, use.name)
        settings = validate(model, use.document, use.settings_at)
        if isinstance(settings, MadeOfOthers):
            for inside, other in settings.others().items():
                at = (*use.settings_at, *inside)
                named_at, settings_at = (*at, "plugin"), (*at, "settings")
                part = _Use(use.kind, other.plugin, use.document, named_at, settings_at)
                used += _check(part, registry, problems)
        for place, named in plugins_in(settings):
            inner = _use(use.document, (*use.settings_at, *place), named)
            used += _check(inner, registry, problems)
    except PluginError as error:
        at_key = use.named_at == use.settings_at
        problems.add(use.document, use.named_at, error.message, error.hint, key=at_key)
    except InvalidFileError as error:
        problems.include(error.problems)
    return used


def _check_measurand(procedure: LoadedProcedure, registry: Registry, problems: Problems) -> None:
    """Add a problem where the measurand is missing, has another unit, or is given twice."""
    document, measurand = procedure.document, procedure.model.measurand
    giving: list[tuple[Path, AnalysisRecord]] = []
    for path, plugin in procedure.model.analyses_at:
        with suppress(PluginError):  # reported by the check of the plugins
            record = registry.record(plugin.kind, plugin.name)
            if isinstance(record, AnalysisRecord) and record.measurand:
                giving.append((path, record))
    for path, record in giving[1:]:
        message = f"'{record.name}' is a second analysis of {record.measurand}"
        problems.add(document, path[:-1], message, "a procedure has only one")
    if not giving:
        return
    dimension = giving[0][1].measurand
    if measurand is None:
        hint = f"the analysis of {dimension} names it"
        problems.add(document, ("measurand",), "the key 'measurand' is missing", hint, key=True)
    elif measurand.unit is not None and (unit_ := unit(measurand.unit)).dimension != dimension:
        message = f"'{unit_.symbol}' is a unit of {unit_.dimension}, not of {dimension}"
        hint = f"units of {dimension}: {', '.join(units_of(dimension))}"
        problems.add(document, ("measurand", "unit"), message, hint)
