"""Whether the limits of a procedure are limits of results that its analyses name."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.errors import PluginError
from rigrunner.api.units import unit
from rigrunner.procedure.result_limits import ResultLimit
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.findings import ResultDefinition
    from rigrunner.procedure.loading import LoadedProcedure
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

    Those of an analysis that is not there, or refuses its settings, are left out: they are told by
    the check of the plugins.
    """
    for path, plugin in procedure.model.named_analyses_at:
        try:
            found = lookup.definitions(plugin.name, plugin.settings)
        except PluginError:
            continue
        for each in found:
            yield (*path, plugin.name), each


def check_result_limits(procedure: LoadedProcedure, lookup: DefinitionLookup) -> None:
    """Raise InvalidFileError with every limit of a result that is not named, or of another kind."""
    problems, known = Problems(), dict[str, "ResultDefinition"]()
    document = procedure.document
    for path, definition in definitions_of(procedure, lookup):
        if definition.name in known:
            message = f"there are two results '{definition.name}'"
            problems.add(document, path, message, "give one of them another name", key=True)
        known.setdefault(definition.name, definition)
    acceptance = procedure.model.acceptance
    for index, limit in enumerate(acceptance.limits if acceptance else ()):
        if isinstance(limit, ResultLimit):
            _check(problems, document, ("acceptance", "limits", index), limit, known)
    problems.stop_if_any()


def _check(
    problems: Problems,
    document: Document,
    path: Path,
    limit: ResultLimit,
    known: Mapping[str, ResultDefinition],
) -> None:
    found = known.get(limit.of)
    if found is None:
        near = difflib.get_close_matches(limit.of, known, n=1)
        named = f"results: {', '.join(known) or 'none, as no analysis names one'}"
        hint = f"did you mean '{near[0]}'?" if near else named
        problems.add(document, (*path, "of"), f"there is no result '{limit.of}'", hint)
        return
    kind = unit(found.unit).dimension
    for key in ("min", "max"):
        given = getattr(limit, key)
        if given is not None and given.dimension != kind:
            message = f"'{given}' is a {given.dimension}; {found.name} is a {kind}, in {found.unit}"
            problems.add(document, (*path, key), message, f"write it in {found.unit}")
    for name in limit.where:
        if name not in found.per:
            problems.add(document, (*path, "where", name), *_no_coordinate(found, name))
    if limit.each is not None and limit.each not in found.per:
        problems.add(document, (*path, "each"), *_no_coordinate(found, limit.each))
    open_ = [name for name in found.per if name not in {*limit.where, limit.each}]
    if open_ and not (limit.mean or limit.worst or limit.each):
        several = f"there is a result '{found.name}' for each {' and '.join(open_)}"
        hint = f"say 'each: {open_[0]}', 'mean: yes' or 'worst: yes', or name one under 'where'"
        problems.add(document, (*path, "of"), several, hint)


def _no_coordinate(found: ResultDefinition, name: str) -> tuple[str, str]:
    near = difflib.get_close_matches(name, found.per, n=1)
    known = f"it has: {', '.join(found.per) or 'none'}"
    hint = f"did you mean '{near[0]}'?" if near else known
    return f"'{found.name}' has no coordinate '{name}'", hint
