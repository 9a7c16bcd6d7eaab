"""Whether the limits of a procedure are limits of results that its analyses name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.conditions import each_until
from rigrunner.api.errors import PluginError, did_you_mean
from rigrunner.api.quantity import Quantity
from rigrunner.procedure.result_limits import unlike
from rigrunner.procedure.walk import steps_of
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.conditions import Until
    from rigrunner.api.findings import ResultDefinition
    from rigrunner.procedure.loading import LoadedProcedure
    from rigrunner.procedure.result_limits import Limit
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path


class DefinitionLookup(Protocol):
    """Knows which results each analysis names."""

    def definitions(self, name: str, settings: Mapping[str, Any]) -> tuple[ResultDefinition, ...]:
        """Return them, known from the settings alone; raise PluginError."""
        ...


def definitions_of(
    procedure: LoadedProcedure, lookup: DefinitionLookup
) -> Iterator[tuple[Path, ResultDefinition]]:
    """Yield each result that a procedure names, and which analysis makes it.

    Those of an analysis that is missing, or refuses its settings, are left out: the check of the
    plugins reports them.
    """
    for path, plugin in procedure.model.analyses_at:
        try:
            found = lookup.definitions(plugin.name, plugin.settings)
        except PluginError:
            continue
        for each in found:
            yield path, each


def all_named(procedure: LoadedProcedure, lookup: DefinitionLookup) -> bool:
    """Say whether each analysis states its results: one that is refused does not."""
    try:
        for _, plugin in procedure.model.analyses_at:
            lookup.definitions(plugin.name, plugin.settings)
    except PluginError:
        return False
    return True


def check_result_limits(procedure: LoadedProcedure, lookup: DefinitionLookup) -> None:
    """Raise InvalidFileError with every limit of a result that is not named, or of another kind."""
    problems, known = Problems(), dict[str, "ResultDefinition"]()
    document = procedure.document
    for path, definition in definitions_of(procedure, lookup):
        if definition.name in known:
            message = f"there are two results '{definition.name}'"
            problems.add(document, path, message, "give one of them another name", key=True)
        known.setdefault(definition.name, definition)
    complete = all_named(procedure, lookup)
    acceptance = procedure.model.acceptance
    asked = [plugin.name for _, plugin in procedure.model.analyses_at]
    for index, limit in enumerate(acceptance.limits if acceptance else ()):
        path = ("acceptance", "limits", index)
        if limit.of in known or complete:
            _check(problems, document, path, limit, known, asked=asked)
    for one in (procedure, *procedure.all_called()) if complete else ():
        _check_conditions(problems, one, known)
    problems.stop_if_any()


def _check_conditions(
    problems: Problems, procedure: LoadedProcedure, known: Mapping[str, ResultDefinition]
) -> None:
    """Add what is wrong with loops that end by a result."""
    for path, step in steps_of(procedure.model):
        here = (*path, step.kind)
        written = procedure.document.part((*here, "until"))
        for key, until in each_until(getattr(step.settings, "until", ()), written):
            for at, message, hint in _objections_to(until, known):
                problems.add(procedure.document, (*here, *key, at), message, hint)


def _objections_to(
    until: Until, known: Mapping[str, ResultDefinition]
) -> Iterator[tuple[str, str, str]]:
    """Yield what is wrong with one of them: its key, a message and a hint."""
    if until.result is None:
        return
    found = known.get(until.result)
    if found is None:
        message = f"there is no result '{until.result}' of what was recorded by then"
        yield "result", message, _near(until.result, known)
        return
    name, bound = until.bound
    if why := unlike(bound, found):
        yield name, *why


def _near(name: str, known: Mapping[str, ResultDefinition]) -> str:
    named = f"results: {', '.join(known) or 'none, as no analysis names one'}"
    return did_you_mean(name, known, named)


def _check(
    problems: Problems,
    document: Document,
    path: Path,
    limit: Limit,
    known: Mapping[str, ResultDefinition],
    *,
    asked: Sequence[str],
) -> None:
    found = known.get(limit.of)
    if found is None:
        message = f"there is no result '{limit.of}'"
        problems.add(document, (*path, "of"), message, _near(limit.of, known))
        return
    _check_values(problems, document, path, limit, found)
    message, hint = limit.objection_to(found, asked)
    if message:
        at = path if limit.measurand is None else (*path, "measurand")
        problems.add(document, at, message, hint)
    for key, places in (("where", limit.where), ("except", limit.except_)):
        for name in places:
            if name not in found.per:
                problems.add(document, (*path, key, name), *_no_coordinate(found, name))
    if limit.each is not None and limit.each not in found.per:
        problems.add(document, (*path, "each"), *_no_coordinate(found, limit.each))
    # One value under `where` fixes a coordinate, and `each` runs over one: others leave several.
    single = {name for name, values in limit.where.items() if len(values) == 1}
    open_ = [name for name in found.per if name not in {*single, limit.each}]
    if open_ and not (limit.mean or limit.worst or limit.each):
        several = f"there is a result '{found.name}' for each {' and '.join(open_)}"
        hint = f"say 'each: {open_[0]}', 'mean: yes' or 'worst: yes', or name one under 'where'"
        problems.add(document, (*path, "of"), several, hint)


def _check_values(
    problems: Problems, document: Document, path: Path, limit: Limit, found: ResultDefinition
) -> None:
    for place, message, hint in limit.unlike(found):
        problems.add(document, (*path, *place), message, hint)
    for name, end in limit.ends.items():
        if not isinstance(end, Quantity) and end.over not in found.per:
            problems.add(document, (*path, name, "over"), *_no_coordinate(found, end.over))


def _no_coordinate(found: ResultDefinition, name: str) -> tuple[str, str]:
    known = f"it has: {', '.join(found.per) or 'none'}"
    hint = did_you_mean(name, found.per, known)
    return f"'{found.name}' has no coordinate '{name}'", hint
