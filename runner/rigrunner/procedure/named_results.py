"""Whether the limits of a procedure are limits of results that its analyses name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.conditions import each_until
from rigrunner.api.errors import PluginError, did_you_mean
from rigrunner.api.quantity import Quantity
from rigrunner.procedure.result_limits import misfit
from rigrunner.procedure.walk import steps_of
from rigrunner.yamlfile.problems import Problems, suggestion

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.conditions import Until
    from rigrunner.api.findings import ResultDefinition
    from rigrunner.procedure.loading import LoadedProcedure
    from rigrunner.procedure.result_limits import Limit
    from rigrunner.registry import Registry
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path


def definitions_of(
    procedure: LoadedProcedure, registry: Registry
) -> Iterator[tuple[Path, ResultDefinition]]:
    """Yield each result that a procedure names, and which analysis makes it.

    Those of an analysis that is missing, or refuses its settings, are left out: the check of the
    plugins reports them.
    """
    for path, plugin in procedure.model.analyses_at:
        try:
            definitions = registry.definitions(plugin.name, plugin.settings)
        except PluginError:
            continue
        for definition in definitions:
            yield path, definition


def all_named(procedure: LoadedProcedure, registry: Registry) -> bool:
    """Say whether each analysis states its results: one that is refused does not."""
    try:
        for _, plugin in procedure.model.analyses_at:
            registry.definitions(plugin.name, plugin.settings)
    except PluginError:
        return False
    return True


def check_result_limits(procedure: LoadedProcedure, registry: Registry) -> None:
    """Raise InvalidFileError with every limit of a result that is not named, or of another kind."""
    problems, definitions = Problems(), dict[str, "ResultDefinition"]()
    document = procedure.document
    for path, definition in definitions_of(procedure, registry):
        if definition.name in definitions:
            message = f"there are two results '{definition.name}'"
            problems.add(document, path, message, "give one of them another name", key=True)
        definitions.setdefault(definition.name, definition)
    complete = all_named(procedure, registry)
    acceptance = procedure.model.acceptance
    analyses = [plugin.name for _, plugin in procedure.model.analyses_at]
    for index, limit in enumerate(acceptance.limits if acceptance else ()):
        path = ("acceptance", "limits", index)
        if limit.of in definitions or complete:
            _check(problems, document, path, limit, definitions, analyses=analyses)
    for part in (procedure, *procedure.all_called()) if complete else ():
        _check_conditions(problems, part, definitions)
    problems.stop_if_any()


def _check_conditions(
    problems: Problems, procedure: LoadedProcedure, definitions: Mapping[str, ResultDefinition]
) -> None:
    """Add what is wrong with loops that end by a result."""
    for path, step in steps_of(procedure.model):
        here = (*path, step.kind)
        written = procedure.document.part((*here, "until"))
        for key, until in each_until(getattr(step.settings, "until", ()), written):
            for at, message, hint in _objections_to(until, definitions):
                problems.add(procedure.document, (*here, *key, at), message, hint)


def _objections_to(
    until: Until, definitions: Mapping[str, ResultDefinition]
) -> Iterator[tuple[str, str, str]]:
    """Yield what is wrong with one of them: its key, a message and a hint."""
    if until.result is None:
        return
    definition = definitions.get(until.result)
    if definition is None:
        message = f"there is no result '{until.result}' of what was recorded by then"
        yield "result", message, _near(until.result, definitions)
        return
    name, bound = until.bound
    if problem := misfit(bound, definition):
        yield name, *problem


def _near(name: str, names: Mapping[str, ResultDefinition]) -> str:
    listed = f"results: {', '.join(names) or 'none, as no analysis names one'}"
    return did_you_mean(name, names, listed)


def _check(
    problems: Problems,
    document: Document,
    path: Path,
    limit: Limit,
    definitions: Mapping[str, ResultDefinition],
    *,
    analyses: Sequence[str],
) -> None:
    definition = definitions.get(limit.of)
    if definition is None:
        message = f"there is no result '{limit.of}'"
        problems.add(document, (*path, "of"), message, _near(limit.of, definitions))
        return
    _check_values(problems, document, path, limit, definition)
    message, hint = limit.objection_to(definition, analyses)
    if message:
        at = path if limit.measurand is None else (*path, "measurand")
        problems.add(document, at, message, hint)
    for key, places in (("where", limit.where), ("except", limit.except_)):
        for name in places:
            if name not in definition.per:
                problems.add(document, (*path, key, name), *_no_coordinate(definition, name))
    if limit.each is not None and limit.each not in definition.per:
        problems.add(document, (*path, "each"), *_no_coordinate(definition, limit.each))
    # One value under `where` fixes a coordinate, and `each` runs over one: others leave several.
    single = {name for name, values in limit.where.items() if len(values) == 1}
    open_ = [name for name in definition.per if name not in {*single, limit.each}]
    if open_ and not (limit.mean or limit.worst or limit.each):
        message = f"there is a result '{definition.name}' for each {' and '.join(open_)}"
        hint = f"say 'each: {open_[0]}', 'mean: yes' or 'worst: yes', or name one under 'where'"
        problems.add(document, (*path, "of"), message, hint)


def _check_values(
    problems: Problems, document: Document, path: Path, limit: Limit, definition: ResultDefinition
) -> None:
    for place, message, hint in limit.misfits(definition):
        problems.add(document, (*path, *place), message, hint)
    for name, end in limit.ends.items():
        if not isinstance(end, Quantity) and end.over not in definition.per:
            problems.add(document, (*path, name, "over"), *_no_coordinate(definition, end.over))


def _no_coordinate(definition: ResultDefinition, name: str) -> tuple[str, str]:
    hint = suggestion(name, definition.per, "it has")
    return f"'{definition.name}' has no coordinate '{name}'", hint
