"""The numbers of a result under flat names, and what moved between two such lists.

The names are the guard's own: where the layout of a result changes, the look-ups here follow, and
the recorded names and numbers stay.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

Flat = dict[str, Any]
RELATIVE = 1e-9
"""How far a value may move, of itself."""
OF_U = 1e-6
"""How far a value may move, of its expanded uncertainty; and an uncertainty, of itself."""
OF_LINES = 1e-5
"""The same for lines of the budget (of its U) and for what serves checks alone.

A processor without AVX2 moves some of them by 4e-6, and no result beyond the limits above.
"""


def flat(result: Mapping[str, Any]) -> Flat:
    """Return what was found: values, uncertainties, the verdict and each check, by flat names."""
    return {name: value for name, value in _pairs(result) if value is not None}


def _pairs(result: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    headline = result["headline"]
    for name in ("compensated", "raw_peak"):
        yield from _quantity(f"headline {name}", headline[name])
    for line in headline["budget"]:
        yield f"budget, {line['name']}", line["contribution"]["value"]
    yield from _decision(result["decision"])
    yield from _checks("check", result["checks"])
    for point in result["points"]:
        at = point["recording"]
        yield from _quantity(f"{at} frequency", point["frequency"])
        yield f"{at} raw peak", point["raw_peak"]["mean"]["value"]
        yield f"{at} cycles kept", point["raw_peak"]["cycles_kept"]
    for method, found in result["compensations"].items():
        for number, point in enumerate(found["points"] or ()):
            yield from _quantity(f"{method} {number} torque", point["torque"])
        for name, value in (found["parameters"] or {}).items():
            yield from _quantity(f"parameter {method} {name}", value)
        yield from _checks(f"{method} check", found["checks"])
    for fit in result["fits"]:
        for name, value in ((fit["curve"] or {}).get("coefficients") or {}).items():
            yield f"fit {fit['name']} {name}", value["value"]
            yield f"fit {fit['name']} {name} u", value["standard_uncertainty"]


def _quantity(name: str, found: Mapping[str, Any] | None) -> Iterator[tuple[str, Any]]:
    if found is None:
        return
    yield name, found["value"]
    yield f"{name} U", found.get("expanded_uncertainty_95")


def _decision(found: Mapping[str, Any] | None) -> Iterator[tuple[str, Any]]:
    if found is None:
        return
    yield "verdict", found["verdict"]
    yield "probability of conformity", found["probability_of_conformity"]
    yield "false accept", found["stated_risk"]["false_accept"]


def _checks(kind: str, found: list[Mapping[str, Any]]) -> Iterator[tuple[str, Any]]:
    for number, each in enumerate(found):
        name = f"{kind} {number} {each['name']}"
        yield name, each["ok"]
        yield f"{name}, value", each["value"]


def moved(before: Flat, now: Flat) -> list[str]:
    """Return in words what is gone, new or different, but for rounding; empty where nothing is."""
    gone = [f"{name}: gone, was {before[name]}" for name in before if name not in now]
    new = [f"{name}: new, is {now[name]}" for name in now if name not in before]
    other = [
        f"{name}: {before[name]!r} -> {now[name]!r}"
        for name in before
        if name in now and not _same(before[name], now[name], _allowed(name, before))
    ]
    return gone + new + other


def _allowed(name: str, before: Flat) -> float:
    """Return how far a number may move in its own unit, beyond RELATIVE."""
    run, is_of_budget, _ = name.partition("budget, ")  # a line may have ': ' in its name
    if is_of_budget:
        return OF_LINES * before.get(f"{run}headline compensated U", 0.0)
    line = name.rpartition(": ")[2]
    if line == "probability of conformity":
        return OF_U  # it moves with U
    is_diagnostic = line.startswith("parameter ") or line.endswith(", value")
    share = OF_LINES if is_diagnostic else OF_U
    if line.endswith((" U", " u", ", value")):
        return share * abs(before[name])
    return share * before.get(f"{name} U", 0.0)


def _same(before: Any, now: Any, allowed: float) -> bool:
    if not isinstance(before, float) or not isinstance(now, float):
        return before == now
    return math.isclose(before, now, rel_tol=RELATIVE, abs_tol=allowed)
