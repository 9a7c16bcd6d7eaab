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
from rigrunner_plugins.analyses.equation.kinds import formula_text
from rigrunner_plugins.analyses.equation.settings import symbol_of
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
    stated = {symbol_of(result): result.name for result in settings.all_results}
    quantities = {name: str(quantity) for name, quantity in settings.parsed.literals.items()}
    equations = settings.parsed.equations
    for index, equation in enumerate(equations):
        following = [stated[later.name] for later in equations[index:] if later.name in stated]
        used = equation.expression.names()
        yield Formula(
            of=following[0] if following else settings.all_results[-1].name,
            symbol=equation.name,
            text=formula_text(equation.expression.root).replace("^", "**"),
            quantities={name: text for name, text in quantities.items() if name in used},
        )


def tables(
    settings: EquationSettings, by_place: Sequence[Sequence[Evaluated]], units: Mapping[str, str]
) -> Iterator[Table]:
    """Yield the tables of results by place; the tables of inputs show the first place.

    `units` has the SI unit of each channel.
    """
    first = next((result for results in by_place for result in results), None)
    if first is None:
        return
    name = first.result.name
    at = f" at {first.result.place}" if first.result.place else ""
    yield _input_table(settings, first, units, f"Inputs of the model{at}")
    pairs = list(_correlation_rows(first))
    if pairs:
        yield Table(of=name, title=f"Correlation of the inputs{at}",
                    columns=("", "", "r"), rows=tuple(pairs))  # fmt: skip
    if any(len(results) > 1 for results in by_place):
        yield Table(
            of=name,
            title="Correlation of the results",
            columns=("", "", "where", "r"),
            rows=tuple(
                (one.result.name, other.result.name, one.result.place, correlation(one, other))
                for results in by_place
                for one, other in combinations(results, 2)
            ),
        )


def both_methods(tried: Sequence[Evaluated]) -> Iterator[Table]:
    """Yield the GUM and Monte Carlo values of results of one name."""
    rows = [row for result in tried if (row := _comparison_row(result)) is not None]
    if rows:
        definition = tried[0].result.of
        named = ("y", "u", "low", "high")
        columns = [f"{name} ({how})" for how in ("GUM", "Monte Carlo") for name in named]
        title = f"GUM and Monte Carlo, in {definition.unit}; 95 % from low to high"
        yield Table(of=definition.name, title=title,
                    columns=("where", *columns, f"agree to {DIGITS} digit of u"),
                    rows=tuple(rows))  # fmt: skip


def correlation(one: Evaluated, other: Evaluated) -> float:
    """Return the correlation coefficient of two results of the same inputs (GUM 5.2.2, H.2)."""
    u = np.array([0.0 if np.isnan(input_.u) else input_.u for input_ in one.model.inputs])
    r: Array = np.eye(len(u)) if one.model.correlation is None else one.model.correlation
    a, b = sensitivities(one.model) * u, sensitivities(other.model) * u
    product_of_u = sqrt(float(a @ r @ a) * float(b @ r @ b))
    return float(a @ r @ b) / product_of_u if product_of_u else 0.0


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


def _input_table(
    settings: EquationSettings, first: Evaluated, units: Mapping[str, str], title: str
) -> Table:
    tree = first.model.equation
    fixed = tree.fixed if isinstance(tree, Tree) else {}
    rows: list[tuple[float | str, ...]] = []
    for input_ in first.model.inputs:
        value, symbol = _on_its_scale(settings, input_.name, input_.value, input_.unit)
        value = round(value, places(input_.u, 3)) if input_.u > 0 else value
        dof: float | str = input_.dof if np.isfinite(input_.dof) else "∞"
        rows.append(
            (input_.name, value, float(f"{input_.u:.3g}"), dof, str(input_.distribution), symbol)
        )
    for name, source in settings.inputs.items():
        if name in fixed:
            value, symbol = _on_its_scale(settings, name, fixed[name], units[source.of])
            remark = "no scatter" if source.is_channel else f"result {source.of}, by its budget"
            rows.append((name, value if np.isfinite(value) else "no value", remark, "", "", symbol))
    for name, constant in settings.constants.items():
        if name in fixed:
            stated = constant.value
            rows.append((name, stated.number, "exact", "", "", stated.unit.symbol))
    columns = ("", "estimate", "u", "degrees of freedom", "distribution", "unit")
    return Table(of=first.result.name, title=title, columns=columns, rows=tuple(rows))


def _correlation_rows(evaluated: Evaluated) -> Iterator[tuple[str, str, float]]:
    r = evaluated.model.correlation
    if r is None:
        return
    names = [input_.name for input_ in evaluated.model.inputs]
    for i, j in combinations(range(len(names)), 2):
        if r[i, j]:
            yield names[i], names[j], float(r[i, j])


def _comparison_row(evaluated: Evaluated) -> tuple[float | str, ...] | None:
    trial, estimate = evaluated.trial, evaluated.result.estimate
    if trial is None or np.isnan(trial.u):
        return None
    expanded_u = expanded(estimate)
    low, high = estimate.value - expanded_u, estimate.value + expanded_u
    deviation = max(abs(low - trial.low), abs(high - trial.high))
    agrees = deviation <= numerical_tolerance(estimate.u, DIGITS)
    shown = (estimate.value, estimate.u, low, high, trial.mean, trial.u, trial.low, trial.high)
    decimals = places(estimate.u, 3)
    return (
        evaluated.result.place,
        *(round(number, decimals) for number in shown),
        "yes" if agrees else "no",
    )
