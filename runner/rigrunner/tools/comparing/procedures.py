"""Differences of two procedures: inputs, steps, analyses and limits."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, PluginError
from rigrunner.procedure import parse_procedure
from rigrunner.registry import load_registry
from rigrunner.tools.comparing.tree import Change, changes
from rigrunner.yamlfile import parse
from rigrunner.yamlfile.upgrade import upgraded

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.procedure import Procedure

SECTIONS = (
    *("id", "revision", "title", "description", "measurand", "inputs", "uses", "parameters"),
    *("setup", "main", "teardown", "analysis", "acceptance"),
)
_WITH_DEFAULTS = ("measurand", "acceptance")
"""Sections in which a key that is written with its default is no difference, as in analyses."""
SET_POINTS = "set-points"


@dataclass(frozen=True)
class ProcedureTexts:
    """A procedure with all that it calls, as stored with a run."""

    name: str
    text: str
    called: Mapping[str, str] = field(default_factory=dict)


def procedure_changes(before: ProcedureTexts, after: ProcedureTexts) -> Iterator[Change]:
    """Yield the differences of two procedures. Comments and layout do not count."""
    yield from _text_changes(before.name, before.text, after.name, after.text)
    for file in dict.fromkeys([*before.called, *after.called]):
        first, second = before.called.get(file), after.called.get(file)
        if first is None or second is None:
            verb = "is called now" if first is None else "is no longer called"
            yield Change("called procedures", f"{file} {verb}")
            continue
        for change in _text_changes(file, first, file, second):
            yield Change("called procedures", f"{file}: {change.section}: {change.text}")


def _text_changes(name: str, text: str, other_name: str, other_text: str) -> Iterator[Change]:
    before = parse(upgraded(text, name), name).data
    after = parse(upgraded(other_text, other_name), other_name).data
    equal = _equal_sections(name, text, other_name, other_text)
    points = _swept_parameters(before) | _swept_parameters(after)
    for section in dict.fromkeys([*SECTIONS, *before, *after]):
        first, second = before.get(section), after.get(section)
        if section in equal:
            continue
        if section == "parameters":
            first, second = first or {}, second or {}
            for key in dict.fromkeys([*first, *second]):
                heading = SET_POINTS if key in points else section
                yield from changes(heading, first.get(key), second.get(key), (key,))
        elif section in {"setup", "main", "teardown"}:
            yield from changes(section, first or [], second or [])
        else:
            yield from changes(section, first, second)


def _equal_sections(name: str, text: str, other_name: str, other_text: str) -> set[str]:
    """Return the sections that are equal with defaults filled in."""
    try:
        first = parse_procedure(text, name, stored=True).model
        second = parse_procedure(other_text, other_name, stored=True).model
    except InvalidFileError:  # of a called procedure, whose values come from its caller
        return set()
    equal = {key for key in _WITH_DEFAULTS if getattr(first, key) == getattr(second, key)}
    return equal | ({"analysis"} if _analyses(first) == _analyses(second) else set())


def _analyses(procedure: Procedure) -> list[tuple[str, object]]:
    """Return the analyses with the defaults of those that are installed."""
    registry, analyses = load_registry(), list[tuple[str, object]]()
    for analysis in procedure.analysis:
        settings: object = analysis.settings
        with suppress(PluginError):
            settings = registry.validated(analysis.kind, analysis.name, analysis.settings)
        analyses.append((analysis.name, settings))
    return analyses


def _swept_parameters(tree: object) -> set[str]:
    """Return the parameters that a sweep goes over, at any depth: `over: $name`."""
    if isinstance(tree, list):
        return set().union(*map(_swept_parameters, tree))
    if not isinstance(tree, dict):
        return set()
    over = tree.get("over")
    swept = {over[1:]} if isinstance(over, str) and over.startswith("$") else set()
    return swept.union(*map(_swept_parameters, tree.values()))
