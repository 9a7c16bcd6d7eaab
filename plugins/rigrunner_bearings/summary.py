"""The torque in a terminal and in comparisons: its keys of a result document."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, Any

from rigrunner.api.summaries import SummaryParts, table
from rigrunner.signal.rounding import UNKNOWN, estimate_text, with_uncertainty

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    Document = Mapping[str, Any]


def _facts(document: Document) -> Iterator[tuple[str, str]]:
    headline = document["headline"]
    if headline["compensated"]:
        raw, compensated = headline["raw_peak"], headline["compensated"]
        yield "raw peak", f"{estimate_text(raw)} {raw['unit']}"
        yield (
            document["measurand"]["name"],
            f"{estimate_text(compensated)} {compensated['unit']} (95 %, {headline['method']})",
        )


def _blocks(document: Document) -> Iterator[str]:
    yield _points(document)
    yield "\n".join(_fits(document))
    validation = document.get("validation") or {"statements": ()}
    yield "\n".join(f"validation: {statement}" for statement in validation["statements"])


def _checks(document: Document) -> Iterator[Document]:
    for compensation in document["compensations"].values():
        yield from compensation["checks"]


def _points(document: Document) -> str:
    """Return raw peak and every method that could be used, per set-point."""
    if not document["points"]:
        return ""
    compensations = document["compensations"].items()
    methods = {name: method for name, method in compensations if method["points"]}
    header = ["set-point", "raw peak", *methods]
    columns = [
        [estimate_text(point["torque"]) for point in method["points"]]
        for method in methods.values()
    ]
    rows = []
    for point, *compensated in zip(document["points"], *columns, strict=True):
        frequency, raw = point["set_frequency"], point["raw_peak"]["mean"]["value"]
        rows.append(
            [
                f"{frequency['value']:g} {frequency['unit']}",
                UNKNOWN if raw is None else f"{raw:.3f}",
                *compensated,
            ]
        )
    missing = [
        f"{name}: not applicable: {method['not_applicable']}"
        for name, method in compensations
        if method["not_applicable"]
    ]
    caption = "Torque in N·m, with its expanded uncertainty (95 %)" if methods else "Torque in N·m"
    return "\n".join([caption, table(header, rows, "r" * len(header)), *missing])


def _fits(document: Document) -> Iterator[str]:
    """Yield the fits of a run that is not compensated: there they are the result."""
    if document["compensations"] or not document["fits"]:
        return
    yield "Fits of the raw peak over frequency, with standard uncertainties"
    for fit in document["fits"]:
        curve = fit["curve"]
        if curve is None:
            yield f"{fit['name']}: no fit: {fit['problem']}"
            continue
        yield f"{fit['name']}: {curve['formula']}"
        for name, coefficient in curve["coefficients"].items():
            value = with_uncertainty(coefficient["value"], coefficient["standard_uncertainty"])
            yield f"  {name} = {value} {coefficient['unit']}"


def _results(document: Document) -> Iterator[Document]:
    """Yield the torque at each set-point: by the primary method, or else the mean raw peak."""
    headline, methods = document.get("headline") or {}, document.get("compensations") or {}
    primary = methods.get(headline.get("method")) or {}
    torques = [(point, point["torque"]) for point in primary.get("points") or ()]
    torques = torques or [(point, _raw_peak(point)) for point in document.get("points") or ()]
    for point, torque in torques:
        hz = point["set_frequency"]["value"]
        coordinates = {} if hz is None else {"frequency": {"value": hz, "unit": "Hz"}}
        yield {"name": "torque", "coordinates": coordinates, "estimate": torque}


def _raw_peak(point: Document) -> Document:
    """Return a mean peak with the expanded uncertainty of its scatter (GUM 4.2.3, G.3.4).

    What the sensor adds is not in it.
    """
    from rigrunner.signal.uncertainty import coverage_factor  # noqa: PLC0415  (scipy)

    peak = point["raw_peak"]
    kept, deviation = peak["cycles_kept"], peak["standard_deviation"]["value"]
    has_scatter = kept > 1 and deviation is not None
    expanded = coverage_factor(kept - 1) * deviation / sqrt(kept) if has_scatter else None
    return {**peak["mean"], "expanded_uncertainty_95": expanded, "note": " from scatter alone"}


SUMMARY = SummaryParts(
    facts=_facts,
    blocks=_blocks,
    checks=_checks,
    reads=("points", "no_load_points", "compensations", "fits", "validation"),
    results=_results,
)
