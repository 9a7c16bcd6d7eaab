"""Compare results by their difference and its expanded uncertainty."""

from __future__ import annotations

from math import copysign, hypot, inf, isclose, nan
from typing import TYPE_CHECKING, Any

from rigrunner.analysis.verdict.document import verdict_in
from rigrunner.api.analysis import Component
from rigrunner.api.quantity import Estimate
from rigrunner.api.units import unit as kind_of
from rigrunner.api.units import with_symbol
from rigrunner.run.set_points import (
    coordinates_in,
    estimates_of_packages,
    named_place,
    other_results,
    unread,
)
from rigrunner.signal.coverage import excess_kurtosis
from rigrunner.signal.coverage import expanded as coverage
from rigrunner.signal.rounding import places, places_apart, places_of_margin
from rigrunner.signal.uncertainty import combine
from rigrunner.tools.comparing.tree import Change, changes

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    Json = Mapping[str, Any]

SECTION = "results"
ROUNDING = 1e-9
"""An E_n that is above 1 by this much is 1: 0.75 - 0.7 is 0.050000000000000044."""


def result_changes(
    before: Json | None, after: Json | None, channels: Collection[str] = ()
) -> Iterator[Change]:
    """Yield how the results of two runs differ, from their result documents.

    Each value is compared by E_n = |difference| / sqrt(U1² + U2²), with the expanded uncertainties
    (ISO/IEC 17043:2023, B.3.1.3; ISO 13528:2022, 9.7): above 1 they do not agree. This is for
    independent results. Gain and offset of the instruments of `channels`, which both runs have with
    one calibration, are one error in both, and enter U of the difference by the difference of
    their effects (GUM 5.2.2 with r = 1). What else both have in common is not known.
    """
    if before is None or after is None:
        if before is not after:
            which = "first" if after is None else "second"
            yield Change(SECTION, f"the {which} run alone has a result")
        return
    yield from changes(SECTION, _verdict(before), _verdict(after), ("verdict",))
    first_judged, second_judged = _judgements(before), _judgements(after)
    for name in {**first_judged, **second_judged}:
        then, now = (judged.get(name, "not measured") for judged in (first_judged, second_judged))
        yield from changes(SECTION, then, now, (name,))
    yield from changes(SECTION, _method(before), _method(after), ("method",))
    name = before["measurand"]["name"]
    yield from _estimates(name, before["headline"]["compensated"], after["headline"]["compensated"])
    yield from _package_changes(before, after)
    first, second = _named_results(before), _named_results(after)
    for key, (what, estimate) in first.items():
        if key in second:
            yield from _estimates(what, estimate, second[key][1], channels)
        else:
            yield Change(SECTION, f"{what} is a result of the first run alone")
    for key, (what, _) in second.items():
        if key not in first:
            yield Change(SECTION, f"{what} is a result of the second run alone")


def _verdict(document: Json) -> str:
    return verdict_in(document) or "no verdict"


def _judgements(document: Json) -> dict[str, str]:
    """Return the verdict on each measured value that has a limit, by its place."""
    values = (document.get("limits") or {}).get("values", ())
    return {f"{each['of']} in {each['table']} {each['row']}": each["verdict"] for each in values}


def _method(document: Json) -> str | None:
    return document["headline"]["method"] or None


def _package_changes(before: Json, after: Json) -> Iterator[Change]:
    """Yield how values in keys of packages differ, and keys that no installed package reads."""
    for key in dict.fromkeys((*unread(before), *unread(after))):
        if before.get(key) != after.get(key):
            yield Change(SECTION, f"{key} differs, and no installed package reads it")
    first, second = (dict(estimates_of_packages(document)) for document in (before, after))
    for place in first:
        if place in second:
            yield from _estimates(place, first[place], second[place])


def _named_results(document: Json) -> dict[object, tuple[str, Json | None]]:
    """Return the results that analyses name, with their words, by name and place in any unit."""
    return {
        (result["name"], frozenset((n, at.usual) for n, at in coordinates_in(result).items())): (
            named_place(result),
            result["estimate"] and {**result["estimate"], "budget": result.get("budget")},
        )
        for result in other_results(document)
    }


def _estimates(
    what: str, before: Json | None, after: Json | None, channels: Collection[str] = ()
) -> Iterator[Change]:
    if not before or not after or before["value"] is None or after["value"] is None:
        return
    unit = after["unit"]
    if before["unit"] != unit:
        kinds = [kind_of(estimate["unit"]).dimension for estimate in (before, after)]
        if kinds[0] != kinds[1]:
            yield Change(SECTION, f"{what} is in {before['unit']} and in {unit}")
            return
        before = _in_unit(before, unit)
    difference = after["value"] - before["value"]
    if difference == 0:
        return
    expanded = [estimate["expanded_uncertainty_95"] for estimate in (before, after)]
    both_known = all(width is not None for width in expanded)
    combined, shared = hypot(*expanded) if both_known else 0.0, _shared(before, after, channels)
    if both_known and shared:
        combined = _uncertainty_of_difference(before, after, shared)
    widths = [width for width in (*expanded, combined) if width]
    # as many decimals as the smaller uncertainty supports
    digits = places_of_margin(max(0, places(min(widths))) if widths else 6, unit)
    ratio = abs(difference) / combined if combined else inf
    agrees = ratio <= 1 + ROUNDING
    if both_known and not agrees:
        digits = places_apart(abs(difference), combined, digits)
    rounded = round(difference, digits) + 0.0  # no negative zero
    first, second = (f"{estimate['value']:.{digits}f}" for estimate in (before, after))
    apart = with_symbol(f"{rounded:+.{digits}f}", unit)
    values = f"{first} and {with_symbol(second, unit)}: {apart}"
    if not both_known:
        text = f"{what}: {values}; whether they agree is not known, as an uncertainty is missing"
        yield Change(SECTION, text)
        return
    note = before.get("note") or after.get("note", "")
    words = f"{'within' if agrees else 'beyond'} their combined U{note}"
    width = with_symbol(f"{combined:.{digits}f}", unit)
    text = f"{what}: {values}, {words} of {width}"
    e_n = f"{ratio:.{2 if agrees else places_apart(ratio, 1.0, 2)}f}"
    e_n += f"; one error of both: {', '.join(shared)}" if shared else ""
    yield Change(SECTION, f"{text} (E_n = {e_n})", matters=not agrees)


def _shared(before: Json, after: Json, channels: Collection[str]) -> list[str]:
    """Return the lines of both budgets that are one error of one instrument."""
    first, second = (_budget_lines(estimate) for estimate in (before, after))
    return [
        name
        for name, line in first.items()
        if any(f"{error} of {channel}" == name.partition(" (")[0]
               for error in ("gain", "offset") for channel in channels)
        and line["standard_uncertainty"] == second.get(name, {}).get("standard_uncertainty")
    ]  # fmt: skip


def _budget_lines(estimate: Json) -> Mapping[str, Json]:
    """Return the budget of an estimate by its lines; none if they do not make up its u."""
    lines = {line["name"]: line for line in estimate.get("budget") or ()}
    parts = [(line["contribution"] or {}).get("value", nan) for line in lines.values()]
    u = estimate.get("standard_uncertainty") or nan
    return lines if isclose(hypot(*parts), u, rel_tol=1e-6) else {}


def _uncertainty_of_difference(before: Json, after: Json, shared: Collection[str]) -> float:
    """Return U of the difference of two estimates in the unit of the second one."""
    scale = kind_of(before["budget"][0]["contribution"]["unit"]).factor
    scale /= kind_of(after["unit"]).factor
    parts: list[Component] = []
    signed = dict.fromkeys(shared, 0.0)
    for factor, estimate in ((-scale, before), (1.0, after)):
        for name, line in _budget_lines(estimate).items():
            u = line["contribution"]["value"] * factor
            if name in signed:
                signed[name] += copysign(u, factor * line["sensitivity"]["value"])
            else:
                parts.append(_component(line, abs(u)))
    parts += [_component(_budget_lines(after)[name], abs(u)) for name, u in signed.items()]
    u, dof = combine(parts)
    kurtosis = excess_kurtosis(((component.u, component.distribution) for component in parts), u)
    return coverage(Estimate(0.0, u, dof, after["unit"], kurtosis))


def _component(line: Json, u: float) -> Component:
    dof = line["degrees_of_freedom"]
    dof = dof if isinstance(dof, float | int) else inf
    return Component(line["name"], u, dof, line["distribution"], common=True)


def _in_unit(estimate: Json, symbol: str) -> Json:
    """Return an estimate of a document in another unit of its kind."""
    source, target = kind_of(estimate["unit"]), kind_of(symbol)
    value = target.from_si(source.to_si(estimate["value"]))
    expanded = estimate["expanded_uncertainty_95"]
    scaled = None if expanded is None else expanded * source.factor / target.factor
    converted = {"value": float(f"{value:.12g}"), "unit": symbol, "expanded_uncertainty_95": scaled}
    return {**estimate, **converted}
