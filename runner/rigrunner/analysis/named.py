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

    from rigrunner.analysis.lookup import Lookup
    from rigrunner.api.analysis import Check, Requirements
    from rigrunner.api.analysis_context import AnalysisContext
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.data import RunData
    from rigrunner.api.findings import MeasurementResult, MissingResult
    from rigrunner.procedure import AnalysisRef


def findings_of(
    run: RunData,
    analyses: Sequence[AnalysisRef],
    lookup: Lookup,
    *,
    context: AnalysisContext | None = None,
    known: Iterable[MeasurementResult] = (),
    missing: Iterable[MissingResult] = (),
    as_far_as_possible: bool = False,
) -> tuple[Findings, ...]:
    """Return what each analysis found in a run, in the order in which they are given.

    `context` is that of the procedure; `known` are results that are there already,
    and `missing` those without a value.
    `as_far_as_possible`: one that cannot be made finds nothing. Raises DataError otherwise, and for
    analyses whose results are made of each other.
    """
    results, without = list(known), list(missing)
    required = [lookup.requires(each.kind, each.name, each.settings) for each in analyses]
    needed = [frozenset(one.name for one in each.results) for each in required]
    found = [Findings()] * len(analyses)
    for index in _in_order(analyses, needed, lookup):
        each = analyses[index]
        given = tuple(one for one in results if one.name in needed[index])
        lacking = tuple(one for one in without if one.name in needed[index])
        with suppress(DataError) if as_far_as_possible else nullcontext():
            made = lookup.make(each.kind, each.name, each.settings, context)
            of = _with_partners(run, each.name, required[index])
            # What needs no results is a plain Analysis, which takes the run alone.
            found[index] = made(of, given, lacking) if needed[index] else made(of)
            results += found[index].results
            without += found[index].missing
            if needed[index]:
                found = [_reaching(one, found[index].results, needed[index]) for one in found]
    return tuple(found)


def _reaching(
    found: Findings, made: Sequence[MeasurementResult], needed: frozenset[str]
) -> Findings:
    """Return findings whose checks of some results are also of the results made of those."""

    def reached(check: Check) -> Check:
        given = [place for name, place in check.of if name in needed]
        also = tuple(
            (each.name, each.coordinates)
            for each in made
            if any(_may_enter(place, each.coordinates) for place in given)
        )
        return replace(check, of=(*check.of, *also))

    return replace(found, checks=tuple(map(reached, found.checks)))


def _may_enter(given: Mapping[str, CoordinateValue], made: Mapping[str, CoordinateValue]) -> bool:
    """Return whether no coordinate tells the place of a result from that of one made of it."""
    return all(made[name].usual == each.usual for name, each in given.items() if name in made)


def makers_of(
    name: str, analyses: Sequence[AnalysisRef], lookup: Lookup
) -> tuple[AnalysisRef, ...]:
    """Return the analyses without which there is no result of that name; none of an unknown one."""
    by_name = _by_name(analyses, lookup)
    needed, waiting = set[int](), [name]
    while waiting:
        index = by_name.get(waiting.pop())
        if index is not None and index not in needed:
            needed.add(index)
            each = analyses[index]
            of = lookup.requires(each.kind, each.name, each.settings).results
            waiting += [one.name for one in of]
    return tuple(each for index, each in enumerate(analyses) if index in needed)


def _with_partners(run: RunData, analysis: str, needs: Requirements) -> RunData:
    """Return a run with the partner runs alone that an analysis requires; raise DataError."""
    wanted = {each.name: each for each in needs.partners}
    for name in wanted.keys() - run.partners.keys():
        if wanted[name].optional:
            continue
        raise DataError(
            f"the analysis '{analysis}' needs a {wanted[name].words}, and {run.run_id} has none",
            hint=f"name one: --partner {name}=RUN",
        )
    there = {name: each for name, each in run.partners.items() if name in wanted}
    return replace(run, partners=there)


def _by_name(analyses: Sequence[AnalysisRef], lookup: Lookup) -> dict[str, int]:
    return {
        definition.name: index
        for index, each in enumerate(analyses)
        for definition in lookup.definitions(each.name, each.settings)
    }


def _in_order(
    analyses: Sequence[AnalysisRef], needed: Sequence[frozenset[str]], lookup: Lookup
) -> Iterable[int]:
    if not any(needed):
        return range(len(analyses))
    by_name = _by_name(analyses, lookup)
    graph = {
        index: sorted(by_name[name] for name in names if name in by_name)
        for index, names in enumerate(needed)
    }
    try:
        return tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        circle = " -> ".join(analyses[index].name for index in error.args[1])
        raise DataError(f"analyses need results of each other: {circle}") from error
