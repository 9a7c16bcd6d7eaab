"""The revisions of the methods by which a result is computed.

A stored result is computed again only by the revisions that computed it. So whoever changes a
method in a way that gives another number, verdict or list of checks counts its revision up by one:
a plugin's in its record, those of the program itself here. Results of version 0.1.0 carry none, and
count as of revision 1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.api.plugin_refs import plugins_in

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.hooks import PluginRecord
    from rigrunner.api.settings import Settings
    from rigrunner.procedure import Acceptance, AnalysisRef

FIRST = 1
"""Of whatever carries no revision."""
ANALYSIS = "analysis"
OWN: Mapping[str, int] = {ANALYSIS: 2}
"""What is no plugin: preparing recordings, the mean, its uncertainty and the checks."""


class RevisionLookup(Protocol):
    """Knows the settings and the revision of every plugin."""

    def validated(self, kind: str, name: str, settings: Mapping[str, Any]) -> Settings:
        """Return the validated settings of a plugin; raise PluginError."""
        ...

    def record(self, kind: str, name: str) -> PluginRecord:
        """Return what a plugin declares; raise PluginError if there is no such plugin."""
        ...

    def revision(self, kind: str, name: str) -> int:
        """Return the revision of an installed plugin; raise PluginError."""
        ...


def revisions_of(
    analyses: Sequence[AnalysisRef], acceptance: Acceptance | None, lookup: RevisionLookup
) -> dict[str, int]:
    """Return the installed revision of each method that analyses use; raise PluginError."""
    return {
        name: OWN[name] if name in OWN else lookup.revision(*name.split(" ", 1))
        for name in methods_of(analyses, acceptance, lookup)
    }


def methods_of(
    analyses: Sequence[AnalysisRef], acceptance: Acceptance | None, lookup: RevisionLookup
) -> tuple[str, ...]:
    """Return the methods that analyses use, as 'analysis' or 'kind name', each once."""
    rule = () if acceptance is None else (f"decision_rule {acceptance.rule.name}",)
    used = (name for each in analyses for name in _methods(each, lookup))
    return tuple(dict.fromkeys((ANALYSIS, *rule, *used)))


def _methods(analysis: AnalysisRef, lookup: RevisionLookup) -> Iterator[str]:
    """Yield an analysis and the plugins that it names.

    One of the measurand was part of the program in version 0.1.0, whose results do not list it: in
    its first revision it is left out.
    """
    own = f"analysis {analysis.name}"
    try:
        settings = lookup.validated(analysis.kind, analysis.name, analysis.settings)
        record = lookup.record(analysis.kind, analysis.name)
    except PluginError:  # not installed, or in a version with other settings
        yield own
        return
    of_measurand = isinstance(record, AnalysisRecord) and record.measurand
    if not of_measurand or record.revision > FIRST:
        yield own
    yield from (f"{each.kind} {each.name}" for _, each in plugins_in(settings))
