"""What the report shows of a measurement model: equations, inputs, correlations, both methods."""

from __future__ import annotations

from itertools import combinations
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import unit
from rigrunner.api.findings import Formula, Table
from rigrunner.api.units import from_si
from rigrunner.signal.coverage import expanded
from rigrunner.signal.monte_carlo.intervals import numerical_tolerance
from rigrunner.signal.propagation import sensitivities
from rigrunner.signal.rounding import places
from rigrunner_plugins.analyses.equation.kinds import written
from rigrunner_plugins.analyses.equation.tree import Tree

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api import Array
    from rigrunner_plugins.analyses.equation.evaluated import Evaluated
    from rigrunner_plugins.analyses.equation.settings import EquationSettings

DIGITS = 1
"""Significant digits of u to which both methods must agree (JCGM 101:2008, 8.1)."""


def formulas(settings: EquationSettings) -> Iterator[Formula]:
    """Yield the equations, each with the result under which it is shown: its own, or the next."""
    stated = {settings.called(each): each.name for each in settings.all_results}
    quantities = {name: str(each) for name, each in settings.parsed.literals.items()}
    equations = settings.parsed.equations
    for index, each in enumerate(equations):
        following = [stated[later.name] for later in equations[index:] if later.name in stated]
        used = each.expression.names()
        yield Formula(
            of=following[0] if following else settings.all_results[-1].name,
            symbol=each.name,
            text=written(each.expression.root).replace("^", "**"),
            quantities={name: text for name, text in quantities.items() if name in used},
        )


def tables(
    settings: EquationSettings, places: Sequence[Sequence[Evaluated]], units: Mapping[str, str]
) -> Iterator[Table]:
    """Yield the tables of results by place; the tables of inputs show the first place.

    `units` has the SI unit of each channel.
    """
    first = next((each for found in places for each in found), None)
    if first is None:
        return
    name = first.result.name
    at = f" at {first.result.place}" if first.result.place else ""
    yield _inputs(settings, first, units, f"Inputs of the model{at}")
    pairs = list(_correlated(first))
    if pairs:
        yield Table(of=name, title=f"Correlation of the inputs{at}",
                    columns=("", "", "r"), rows=tuple(pairs))  # fmt: skip
    if any(len(found) > 1 for found in places):
        yield Table(
            of=name,
            title="Correlation of the results",
            columns=("", "", "where", "r"),
            rows=tuple(
                (one.result.name, other.result.name, one.result.place, correlation(one, other))
                for found in places
                for one, other in combinations(found, 2)
            ),
        )


def both_methods(tried: Sequence[Evaluated]) -> Iterator[Table]:
    """Yield the GUM and Monte Carlo values of results of one name."""
    rows = [row for each in tried if (row := _compared(each)) is not None]
    if rows:
        of = tried[0].result.of
        named = ("y", "u", "low", "high")
        columns = [f"{each} (GUM)" for each in named] + [f"{each} (Monte Carlo)" for each in named]
        yield Table(of=of.name, title=f"GUM and Monte Carlo, in {of.unit}; 95 % from low to high",
                    columns=("where", *columns, f"agree to {DIGITS} digit of u"),
                    rows=tuple(rows))  # fmt: skip


def correlation(one: Evaluated, other: Evaluated) -> float:
    """Return the correlation coefficient of two results of the same inputs (GUM 5.2.2, H.2)."""
    u = np.array([0.0 if np.isnan(each.u) else each.u for each in one.model.inputs])
    r: Array = np.eye(len(u)) if one.model.correlation is None else one.model.correlation
    a, b = sensitivities(one.model) * u, sensitivities(other.model) * u
    whole = sqrt(float(a @ r @ a) * float(b @ r @ b))
    return float(a @ r @ b) / whole if whole else 0.0


def _on_its_scale(
    settings: EquationSettings, name: str, value: float, symbol: str
) -> tuple[float, str]:
    """Return an SI estimate as displayed: temperatures on a scale in °C."""
    is_channel = name in settings.channels
    is_point = is_channel or (
        name in settings.constants and bool(settings.constants[name].value.unit.offset)
    )
    if is_point and unit(symbol).dimension == "temperature":
        return from_si(value, "°C"), "°C"
    return value, symbol


def _inputs(
    settings: EquationSettings, first: Evaluated, units: Mapping[str, str], title: str
) -> Table:
    tree = first.model.equation
    fixed = tree.fixed if isinstance(tree, Tree) else {}
    rows: list[tuple[float | str, ...]] = []
    for each in first.model.inputs:
        value, symbol = _on_its_scale(settings, each.name, each.value, each.unit)
        dof: float | str = each.dof if np.isfinite(each.dof) else "∞"
        rows.append((each.name, value, float(f"{each.u:.3g}"), dof, str(each.distribution), symbol))
    for name, told in settings.inputs.items():
        if name in fixed:
            value, symbol = _on_its_scale(settings, name, fixed[name], units[told.of])
            how = "no scatter" if told.is_channel else f"result {told.of}, by its budget"
            rows.append((name, value if np.isfinite(value) else "no value", how, "", "", symbol))
    for name, constant in settings.constants.items():
        if name in fixed:
            stated = constant.value
            rows.append((name, stated.number, "exact", "", "", stated.unit.symbol))
    columns = ("", "estimate", "u", "degrees of freedom", "distribution", "unit")
    return Table(of=first.result.name, title=title, columns=columns, rows=tuple(rows))


def _correlated(found: Evaluated) -> Iterator[tuple[str, str, float]]:
    r = found.model.correlation
    if r is None:
        return
    names = [each.name for each in found.model.inputs]
    for i, j in combinations(range(len(names)), 2):
        if r[i, j]:
            yield names[i], names[j], float(r[i, j])


def _compared(found: Evaluated) -> tuple[float | str, ...] | None:
    trial, estimate = found.trial, found.result.estimate
    if trial is None or np.isnan(trial.u):
        return None
    reach = expanded(estimate)
    low, high = estimate.value - reach, estimate.value + reach
    off = max(abs(low - trial.low), abs(high - trial.high))
    agrees = off <= numerical_tolerance(estimate.u, DIGITS)
    shown = (estimate.value, estimate.u, low, high, trial.mean, trial.u, trial.low, trial.high)
    decimals = places(estimate.u, 3)
    return (
        found.result.place,
        *(round(each, decimals) for each in shown),
        "yes" if agrees else "no",
    )
