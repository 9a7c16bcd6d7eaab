"""The figures of a result that are compared: those that a method or a setting can change."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import TYPE_CHECKING, Any

from rigrunner.analysis.verdict.document import verdict_in
from rigrunner.run.set_points import named_place, other_results, told_apart
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
    found = [(HEADLINE, _estimate(document["headline"]["compensated"]))]
    found += [(named_place(each), _estimate(each["estimate"])) for each in other_results(document)]
    for label, method in document["compensations"].items():
        torques = [(each["set_frequency"]["value"], each["torque"]) for each in method["points"]]
        named = [(at, _estimate(torque)) for at, torque in _named(torques)]
        if label == primary:
            found += [(f"{HEADLINE}{at}", torque) for at, torque in named]
        found += [(f"{label}: torque{at}", torque) for at, torque in named]
        parameters = method["parameters"].items()
        found += [(f"{label}: {name}", _estimate(each)) for name, each in parameters]
    found += list(_fits(document))
    peaks = [(each["set_frequency"]["value"], each["raw_peak"]) for each in document["points"]]
    found += [(f"raw peak{at}", _mean(peak)) for at, peak in _named(peaks)]
    return {name: each for name, each in found if each is not None}


def named_results(document: Json) -> tuple[str, ...]:
    """Return the figures that are named results."""
    return tuple(named_place(each) for each in other_results(document))


def sources(document: Json) -> tuple[str, ...]:
    """Return methods and fits; the names of their figures and checks begin with theirs and ': '."""
    return (*document["compensations"], *(_fit(each) for each in document["fits"]))


def frequencies(document: Json) -> list[AtFrequency]:
    """Return the figures of the primary method at the set-points."""
    method = document["compensations"].get(document["headline"]["method"] or "", {"points": ()})
    found = [(each["set_frequency"]["value"], each) for each in method["points"]]
    names = [f"{HEADLINE}{at}" for at, _ in _named(found)]
    return [
        AtFrequency(hz, name) for (hz, _), name in zip(found, names, strict=True) if hz is not None
    ]


def verdicts(document: Json) -> dict[str, str]:
    """Return the verdict on the run, and on each limit where there are several."""
    found, decision = verdict_in(document), document["decision"]
    if decision is None:
        return {"run": found} if found else {}
    parts = decision["parts"] if len(decision["parts"]) > 1 else []
    named = told_apart((str(each["of"]), str(each["verdict"])) for each in parts)
    return {"run": found, **dict(named)} if found else dict(named)


def checks(document: Json) -> dict[str, bool]:
    """Return whether each check passed; for a check at several places, whether each did."""
    every = [(each["name"], each["ok"]) for each in document["checks"]]
    for label, method in document["compensations"].items():
        every.append((f"{label}: can be applied", not method["not_applicable"]))
        every += [(f"{label}: {each['name']}", each["ok"]) for each in method["checks"]]
    every += [(f"{_fit(each)}: found", each["curve"] is not None) for each in document["fits"]]
    found: dict[str, bool] = {}
    for name, ok in every:
        found[name] = found.get(name, True) and bool(ok)
    return found


def _named(points: list[tuple[float | None, Any]]) -> Iterator[tuple[str, Any]]:
    """Yield each with the name of its set-point, as a suffix of the figure's name."""
    named = (("" if hz is None else f"at {hz:g} Hz", each) for hz, each in points)
    for place, each in told_apart(named):
        yield f" {place}" if place else "", each


def _fits(document: Json) -> Iterator[tuple[str, Figure | None]]:
    for each in document["fits"]:
        curve = each["curve"] or {"coefficients": {}}
        dof = curve.get("degrees_of_freedom")
        for name, found in curve["coefficients"].items():
            yield f"{_fit(each)}: {name}", _coefficient(found, dof)


def _fit(fit: Json) -> str:
    return f"fit {fit['name']}"


def _estimate(found: Json | None) -> Figure | None:
    if not found or found["value"] is None:
        return None
    return Figure(found["value"], found.get("expanded_uncertainty_95"), found["unit"])


def _coefficient(found: Json, dof: object) -> Figure | None:
    if found["value"] is None:
        return None
    u: float | None = found.get("standard_uncertainty")
    freedom = float(dof) if isinstance(dof, int | float) else inf
    expanded = None if u is None or freedom <= 0 else coverage_factor(freedom) * u
    return Figure(found["value"], expanded, found["unit"])


def _mean(peak: Json) -> Figure | None:
    """Return a mean peak with the expanded uncertainty of its scatter alone (GUM 4.2.3, G.3.4)."""
    mean, deviation = peak["mean"]["value"], peak["standard_deviation"]["value"]
    kept = peak["cycles_kept"]
    if mean is None:
        return None
    known = deviation is not None and kept > 1
    expanded = coverage_factor(kept - 1) * deviation / sqrt(kept) if known else None
    return Figure(mean, expanded, TORQUE)
