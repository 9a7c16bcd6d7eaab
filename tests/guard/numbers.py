"""The numbers of a result under flat names, and the differences of two such dicts.

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
"""Allowed change of a value, relative to itself."""
OF_U = 1e-6
"""Allowed change of a value relative to its U, and of an uncertainty relative to itself."""
OF_LINES = 1e-5
"""The same for lines of the budget (relative to U) and for values that only checks use.

A processor without AVX2 moves some of them by 4e-6, and no result beyond the limits above.
"""


def flat(result: Mapping[str, Any]) -> Flat:
    """Return values, uncertainties, the verdict and each check of a result, by flat names."""
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
        recording = point["recording"]
        yield from _quantity(f"{recording} frequency", point["frequency"])
        yield f"{recording} raw peak", point["raw_peak"]["mean"]["value"]
        yield f"{recording} cycles kept", point["raw_peak"]["cycles_kept"]
    for method, compensation in result["compensations"].items():
        for number, point in enumerate(compensation["points"] or ()):
            yield from _quantity(f"{method} {number} torque", point["torque"])
        for name, value in (compensation["parameters"] or {}).items():
            yield from _quantity(f"parameter {method} {name}", value)
        yield from _checks(f"{method} check", compensation["checks"])
    for fit in result["fits"]:
        for name, value in ((fit["curve"] or {}).get("coefficients") or {}).items():
            yield f"fit {fit['name']} {name}", value["value"]
            yield f"fit {fit['name']} {name} u", value["standard_uncertainty"]


def _quantity(name: str, quantity: Mapping[str, Any] | None) -> Iterator[tuple[str, Any]]:
    if quantity is None:
        return
    yield name, quantity["value"]
    yield f"{name} U", quantity.get("expanded_uncertainty_95")


def _decision(decision: Mapping[str, Any] | None) -> Iterator[tuple[str, Any]]:
    if decision is None:
        return
    yield "verdict", decision["verdict"]
    yield "probability of conformity", decision["probability_of_conformity"]
    yield "false accept", decision["stated_risk"]["false_accept"]


def _checks(kind: str, checks: list[Mapping[str, Any]]) -> Iterator[tuple[str, Any]]:
    for number, check in enumerate(checks):
        name = f"{kind} {number} {check['name']}"
        yield name, check["ok"]
        yield f"{name}, value", check["value"]


def differences(before: Flat, now: Flat) -> list[str]:
    """Return a text for each number that is gone, new or different beyond rounding."""
    gone = [f"{name}: gone, was {before[name]}" for name in before if name not in now]
    new = [f"{name}: new, is {now[name]}" for name in now if name not in before]
    changed = [
        f"{name}: {before[name]!r} -> {now[name]!r}"
        for name in before
        if name in now and not _same(before[name], now[name], _allowed(name, before))
    ]
    return gone + new + changed


def _allowed(name: str, before: Flat) -> float:
    """Return the allowed change of a number in its own unit, beyond RELATIVE."""
    run, is_of_budget, _ = name.partition("budget, ")  # a line may have ': ' in its name
    if is_of_budget:
        return OF_LINES * before.get(f"{run}headline compensated U", 0.0)
    line = name.rpartition(": ")[2]
    if line == "probability of conformity":
        return OF_U  # it changes with U
    is_diagnostic = line.startswith("parameter ") or line.endswith(", value")
    share = OF_LINES if is_diagnostic else OF_U
    if line.endswith((" U", " u", ", value")):
        return share * abs(before[name])
    return share * before.get(f"{name} U", 0.0)


def _same(before: Any, now: Any, allowed: float) -> bool:
    if not isinstance(before, float) or not isinstance(now, float):
        return before == now
    return math.isclose(before, now, rel_tol=RELATIVE, abs_tol=allowed)
