"""The figures of a result that are compared: those that a method or a setting can change."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import TYPE_CHECKING, Any

from rigrunner.analysis.verdict.document import verdict_in
from rigrunner.run.set_points import named_place, other_results, with_unique_names
from rigrunner.signal.uncertainty import coverage_factor

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    Json = Mapping[str, Any]

HEADLINE = "result"
TORQUE = "N·m"


@dataclass(frozen=True)
class Figure:
    """A number of a result with its expanded uncertainty of 95 %, in the same unit."""

    value: float
    expanded: float | None
    """None if the result states no uncertainty."""
    unit: str


@dataclass(frozen=True)
class AtFrequency:
    """A figure at a set-point, by the primary method."""

    frequency_hz: float
    figure: str
    """Its name."""


def figures(document: Json) -> dict[str, Figure]:
    """Return every figure of a result document by its name, the results themselves first.

    Names are those of the measured quantity, not of the primary method: a result by another method
    is compared with the one before.
    """
    primary = document["headline"]["method"]
    entries = [(HEADLINE, _estimate(document["headline"]["compensated"]))]
    entries += [
        (named_place(result), _estimate(result["estimate"])) for result in other_results(document)
    ]
    for label, method in document["compensations"].items():
        torques = [(point["set_frequency"]["value"], point["torque"]) for point in method["points"]]
        points = [(place, _estimate(torque)) for place, torque in _named(torques)]
        if label == primary:
            entries += [(f"{HEADLINE}{place}", torque) for place, torque in points]
        entries += [(f"{label}: torque{place}", torque) for place, torque in points]
        parameters = method["parameters"].items()
        entries += [(f"{label}: {name}", _estimate(parameter)) for name, parameter in parameters]
    entries += list(_fits(document))
    peaks = [(point["set_frequency"]["value"], point["raw_peak"]) for point in document["points"]]
    entries += [(f"raw peak{place}", _mean(peak)) for place, peak in _named(peaks)]
    return {name: figure for name, figure in entries if figure is not None}


def named_results(document: Json) -> tuple[str, ...]:
    """Return the figures that are named results."""
    return tuple(named_place(result) for result in other_results(document))


def sources(document: Json) -> tuple[str, ...]:
    """Return methods and fits; the names of their figures and checks begin with theirs and ': '."""
    return (*document["compensations"], *(_fit(fit) for fit in document["fits"]))


def frequencies(document: Json) -> list[AtFrequency]:
    """Return the figures of the primary method at the set-points."""
    method = document["compensations"].get(document["headline"]["method"] or "", {"points": ()})
    points = [(point["set_frequency"]["value"], point) for point in method["points"]]
    names = [f"{HEADLINE}{place}" for place, _ in _named(points)]
    return [
        AtFrequency(hz, name) for (hz, _), name in zip(points, names, strict=True) if hz is not None
    ]


def verdicts(document: Json) -> dict[str, str]:
    """Return the verdict on the run, and on each limit where there are several."""
    verdict, decision = verdict_in(document), document["decision"]
    if decision is None:
        return {"run": verdict} if verdict else {}
    parts = decision["parts"] if len(decision["parts"]) > 1 else []
    on_limits = with_unique_names((str(part["of"]), str(part["verdict"])) for part in parts)
    return {"run": verdict, **dict(on_limits)} if verdict else dict(on_limits)


def checks(document: Json) -> dict[str, bool]:
    """Return whether each check passed; for a check at several places, whether each did."""
    passed = [(check["name"], check["ok"]) for check in document["checks"]]
    for label, method in document["compensations"].items():
        passed.append((f"{label}: can be applied", not method["not_applicable"]))
        passed += [(f"{label}: {check['name']}", check["ok"]) for check in method["checks"]]
    passed += [(f"{_fit(fit)}: found", fit["curve"] is not None) for fit in document["fits"]]
    by_name: dict[str, bool] = {}
    for name, ok in passed:
        by_name[name] = by_name.get(name, True) and bool(ok)
    return by_name


def _named(points: list[tuple[float | None, Any]]) -> Iterator[tuple[str, Any]]:
    """Yield each value with the name of its set-point, as a suffix of the figure's name."""
    labelled = (("" if hz is None else f"at {hz:g} Hz", value) for hz, value in points)
    for place, value in with_unique_names(labelled):
        yield f" {place}" if place else "", value


def _fits(document: Json) -> Iterator[tuple[str, Figure | None]]:
    for fit in document["fits"]:
        curve = fit["curve"] or {"coefficients": {}}
        dof = curve.get("degrees_of_freedom")
        for name, coefficient in curve["coefficients"].items():
            yield f"{_fit(fit)}: {name}", _coefficient(coefficient, dof)


def _fit(fit: Json) -> str:
    return f"fit {fit['name']}"


def _estimate(estimate: Json | None) -> Figure | None:
    if not estimate or estimate["value"] is None:
        return None
    return Figure(estimate["value"], estimate.get("expanded_uncertainty_95"), estimate["unit"])


def _coefficient(coefficient: Json, dof: object) -> Figure | None:
    if coefficient["value"] is None:
        return None
    u: float | None = coefficient.get("standard_uncertainty")
    freedom = float(dof) if isinstance(dof, int | float) else inf
    expanded = None if u is None or freedom <= 0 else coverage_factor(freedom) * u
    return Figure(coefficient["value"], expanded, coefficient["unit"])


def _mean(peak: Json) -> Figure | None:
    """Return a mean peak with the expanded uncertainty of its scatter alone (GUM 4.2.3, G.3.4)."""
    mean, deviation = peak["mean"]["value"], peak["standard_deviation"]["value"]
    count = peak["cycles_kept"]
    if mean is None:
        return None
    has_scatter = deviation is not None and count > 1
    expanded = coverage_factor(count - 1) * deviation / sqrt(count) if has_scatter else None
    return Figure(mean, expanded, TORQUE)
