"""The revisions of the methods by which a result is computed.

A stored result is computed again only by the revisions that computed it. So whoever changes a
method in a way that gives another number, verdict or list of checks counts its revision up by one:
a plugin's in its record, those of the program itself here. Results of version 0.1.0 carry none, and
count as of revision 1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.analysis.lookup import fits_in

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.analysis.lookup import Lookup
    from rigrunner.procedure import Acceptance, AnalysisSpec, NamedAnalysisRef

FIRST = 1
"""Of whatever carries no revision."""
ANALYSIS = "analysis"
OWN: Mapping[str, int] = {ANALYSIS: 2}
"""What is no plugin: preparing recordings, the mean, its uncertainty and the checks."""


def revisions_of(
    spec: AnalysisSpec,
    acceptance: Acceptance | None,
    lookup: Lookup,
    analyses: Sequence[NamedAnalysisRef] = (),
) -> dict[str, int]:
    """Return the installed revision of each method that an analysis uses; raise PluginError."""
    chosen = [
        f"fit {fit.name}"
        for each in analyses
        for fit in fits_in(lookup, each.name, each.settings).values()
    ]
    return {
        name: OWN[name] if name in OWN else lookup.revision(*name.split(" ", 1))
        for name in dict.fromkeys((*methods_of(spec, acceptance, analyses), *chosen))
    }


def methods_of(
    spec: AnalysisSpec,
    acceptance: Acceptance | None,
    analyses: Sequence[NamedAnalysisRef] = (),
) -> Iterator[str]:
    """Yield the methods that an analysis uses, as 'analysis' or 'kind name', each once."""
    yield ANALYSIS
    if acceptance is not None:
        yield f"decision_rule {acceptance.rule.name}"
    if spec.outliers is not None:
        yield f"outlier_rule {spec.outliers.name}"
    yield from dict.fromkeys(f"fit {each.name}" for each in spec.fits)
    yield from dict.fromkeys(f"compensation {each.name}" for each in spec.compensations)
    yield from dict.fromkeys(f"analysis {each.name}" for each in analyses)
