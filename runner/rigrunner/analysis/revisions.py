"""The revisions of the methods by which a result is computed.

A stored result is computed again only by the revisions that computed it. So whoever changes a
method in a way that gives another number, verdict or list of checks counts its revision up by one:
a plugin's in its record, those of the program itself here. Results of version 0.1.0 carry none, and
count as of revision 1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.api.plugin_refs import plugins_in

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.analysis.lookup import Lookup
    from rigrunner.procedure import Acceptance, AnalysisRef

FIRST = 1
"""Of what has no revision of its own."""
ANALYSIS = "analysis"
OWN: Mapping[str, int] = {ANALYSIS: 2}
"""What is no plugin: preparing recordings, the mean, its uncertainty and the checks."""


def revisions_of(
    analyses: Sequence[AnalysisRef], acceptance: Acceptance | None, lookup: Lookup
) -> dict[str, int]:
    """Return the installed revision of each method that analyses use; raise PluginError."""
    return {
        name: OWN[name] if name in OWN else lookup.revision(*name.split(" ", 1))
        for name in methods_of(analyses, acceptance, lookup)
    }


def methods_of(
    analyses: Sequence[AnalysisRef], acceptance: Acceptance | None, lookup: Lookup
) -> tuple[str, ...]:
    """Return the methods that analyses use, as 'analysis' or 'kind name', each once.

    An analysis of the measurand was part of the program in version 0.1.0, whose results do not list
    it: in its first revision it is left out.
    """
    found = [ANALYSIS]
    if acceptance is not None:
        found.append(f"decision_rule {acceptance.rule.name}")
    for each in analyses:
        own = f"analysis {each.name}"
        try:
            settings = lookup.validated(each.kind, each.name, each.settings)
            record = lookup.record(each.kind, each.name)
        except PluginError:  # not installed, or in a version with other settings
            found.append(own)
            continue
        of_measurand = isinstance(record, AnalysisRecord) and record.measurand
        if not of_measurand or record.revision > FIRST:
            found.append(own)
        found += [f"{used.kind} {used.name}" for _, used in plugins_in(settings)]
    return tuple(dict.fromkeys(found))
