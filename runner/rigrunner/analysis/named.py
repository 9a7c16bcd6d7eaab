"""The analyses that name their results, each after those whose results it needs."""

from __future__ import annotations

from contextlib import nullcontext, suppress
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.api.findings import Findings

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigrunner.analysis.scrutiny import Scrutiny
    from rigrunner.api.analysis import Check, Requirements
    from rigrunner.api.analysis_context import AnalysisContext
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.data import RunData
    from rigrunner.api.findings import MeasurementResult, MissingResult
    from rigrunner.procedure import AnalysisRef
    from rigrunner.registry import Registry


def findings_of(
    run: RunData,
    analyses: Sequence[AnalysisRef],
    scrutiny: Scrutiny,
    *,
    context: AnalysisContext | None = None,
    known: Iterable[MeasurementResult] = (),
    missing: Iterable[MissingResult] = (),
    as_far_as_possible: bool = False,
) -> tuple[Findings, ...]:
    """Return the findings of each analysis in a run, in the order of `analyses`.

    `context` is that of the procedure; `known` are results that exist already,
    and `missing` those without a value.
    `as_far_as_possible`: an analysis that fails finds nothing. Raises DataError otherwise, and for
    analyses that need results of each other.
    """
    results, without_value = list(known), list(missing)
    required = [scrutiny.requires(ref.kind, ref.name, ref.settings) for ref in analyses]
    needed = [frozenset(result.name for result in each.results) for each in required]
    findings = [Findings()] * len(analyses)
    for index in _in_order(analyses, needed, scrutiny.registry):
        ref, names = analyses[index], needed[index]
        inputs = tuple(result for result in results if result.name in names)
        missing_inputs = tuple(result for result in without_value if result.name in names)
        with suppress(DataError) if as_far_as_possible else nullcontext():
            analysis = scrutiny.make(ref.kind, ref.name, ref.settings, context)
            data = _with_partners(run, ref.name, required[index])
            # What needs no results is a plain Analysis, which takes the run alone.
            findings[index] = analysis(data, inputs, missing_inputs) if names else analysis(data)
            results += findings[index].results
            without_value += findings[index].missing
            if names:
                outputs = findings[index].results
                findings = [_with_checks_of_outputs(each, outputs, names) for each in findings]
    return tuple(findings)


def _with_checks_of_outputs(
    findings: Findings, outputs: Sequence[MeasurementResult], inputs: frozenset[str]
) -> Findings:
    """Return findings whose checks of some results are also of the results computed from those."""

    def extended(check: Check) -> Check:
        places = [place for name, place in check.of if name in inputs]
        added = tuple(
            (output.name, output.coordinates)
            for output in outputs
            if any(_may_enter(place, output.coordinates) for place in places)
        )
        return replace(check, of=(*check.of, *added))

    return replace(findings, checks=tuple(map(extended, findings.checks)))


def _may_enter(place: Mapping[str, CoordinateValue], output: Mapping[str, CoordinateValue]) -> bool:
    """Return whether no coordinate distinguishes the place of a result from that of an output."""
    return all(output[name].usual == at.usual for name, at in place.items() if name in output)


def makers_of(
    name: str, analyses: Sequence[AnalysisRef], registry: Registry
) -> tuple[AnalysisRef, ...]:
    """Return the analyses without which there is no result of that name; none of an unknown one."""
    by_name = _by_name(analyses, registry)
    needed, waiting = set[int](), [name]
    while waiting:
        index = by_name.get(waiting.pop())
        if index is not None and index not in needed:
            needed.add(index)
            ref = analyses[index]
            required = registry.requires(ref.kind, ref.name, ref.settings)
            waiting += [result.name for result in required.results]
    return tuple(ref for index, ref in enumerate(analyses) if index in needed)


def _with_partners(run: RunData, analysis: str, needs: Requirements) -> RunData:
    """Return a run with only the partner runs that an analysis requires; raise DataError."""
    required = {partner.name: partner for partner in needs.partners}
    for name in required.keys() - run.partners.keys():
        if required[name].optional:
            continue
        raise DataError(
            f"the analysis '{analysis}' needs a {required[name].words}, and {run.run_id} has none",
            hint=f"name one: --partner {name}=RUN",
        )
    partners = {name: partner for name, partner in run.partners.items() if name in required}
    return replace(run, partners=partners)


def _by_name(analyses: Sequence[AnalysisRef], registry: Registry) -> dict[str, int]:
    return {
        definition.name: index
        for index, ref in enumerate(analyses)
        for definition in registry.definitions(ref.name, ref.settings)
    }


def _in_order(
    analyses: Sequence[AnalysisRef], needed: Sequence[frozenset[str]], registry: Registry
) -> Iterable[int]:
    if not any(needed):
        return range(len(analyses))
    by_name = _by_name(analyses, registry)
    graph = {
        index: sorted(by_name[name] for name in names if name in by_name)
        for index, names in enumerate(needed)
    }
    try:
        return tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        cycle = " -> ".join(analyses[index].name for index in error.args[1])
        raise DataError(f"analyses need results of each other: {cycle}") from error
