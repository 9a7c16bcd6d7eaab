"""The revisions of the methods by which a result is computed.

A stored result is computed again only by the revisions that computed it. So whoever changes a
method in a way that gives another number, verdict or list of checks increments its revision:
a plugin's in its record, those of the program itself here. Results of version 0.1.0 have none, and
count as of revision 1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.api.plugin_refs import plugins_in

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.procedure import Acceptance, AnalysisRef
    from rigrunner.registry import Registry

FIRST = 1
"""The revision of a method that states none."""
ANALYSIS = "analysis"
OWN: Mapping[str, int] = {ANALYSIS: 2}
"""Methods of the program itself: preparing recordings, the mean, its uncertainty, the checks."""


def revisions_of(
    analyses: Sequence[AnalysisRef], acceptance: Acceptance | None, registry: Registry
) -> dict[str, int]:
    """Return the installed revision of each method that analyses use; raise PluginError."""
    return {
        name: OWN[name] if name in OWN else registry.revision(*name.split(" ", 1))
        for name in methods_of(analyses, acceptance, registry)
    }


def methods_of(
    analyses: Sequence[AnalysisRef], acceptance: Acceptance | None, registry: Registry
) -> tuple[str, ...]:
    """Return the methods that analyses use, as 'analysis' or 'kind name', each once.

    An analysis of the measurand was part of the program in version 0.1.0, whose results do not list
    it: in its first revision it is left out.
    """
    methods = [ANALYSIS]
    if acceptance is not None:
        methods.append(f"decision_rule {acceptance.rule.name}")
    for ref in analyses:
        method = f"analysis {ref.name}"
        try:
            settings = registry.validated(ref.kind, ref.name, ref.settings)
            record = registry.record(ref.kind, ref.name)
        except PluginError:  # not installed, or in a version with other settings
            methods.append(method)
            continue
        of_measurand = isinstance(record, AnalysisRecord) and record.measurand
        if not of_measurand or record.revision > FIRST:
            methods.append(method)
        methods += [f"{plugin.kind} {plugin.name}" for _, plugin in plugins_in(settings)]
    return tuple(dict.fromkeys(methods))
