"""Propagates a measurement model by the GUM: combined uncertainty, degrees of freedom, budget.

GTC (Measurement Standards Laboratory of New Zealand) does the algebra of uncertain numbers: law of
propagation with correlation (JCGM 100, 5.2.2) and effective degrees of freedom by Welch and
Satterthwaite (G.4.1), extended to inputs of one estimation (Willink, Metrologia 44, 2007, 340).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations
from math import inf, isnan, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner.api.uncertainty import Differentiable, Distribution, Line
from rigrunner.moved import moved
from rigrunner.signal.coverage import KURTOSIS, excess_kurtosis

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.data import Array
    from rigrunner.api.uncertainty import Input, MeasurementModel


UNKNOWN_STEP = 1e-3
"""Over which the sensitivity to an input of unknown uncertainty is taken."""


@dataclass(frozen=True)
class Propagated:
    """The estimate of a measurand by its model, and the uncertainty budget."""

    estimate: Estimate
    components: tuple[Component, ...]


@lru_cache(maxsize=256)
def propagate(model: MeasurementModel) -> Propagated:
    """Return estimate and budget; cached, as the result of a method is compared with its model.

    An input of unknown uncertainty (nan) makes that of the result unknown: nan, and so its degrees
    of freedom. Raises ValueError for correlated inputs that are neither of one ensemble nor both of
    infinite degrees of freedom: nothing says what those of the result would be.
    """
    gradient = sensitivities(model)
    is_known = [not np.isnan(x.u) for x in model.inputs]
    numbers = _uncertain_numbers(model)
    parts = {
        line: _combine(rows, gradient, numbers) if all(is_known[row] for row in rows) else None
        for line, rows in _lines(model).items()
    }
    u, dof = _u_and_dof(None if None in parts.values() else sum(parts.values()))
    # By inputs, not by lines: only of the inputs are the shapes known.
    kurtosis = excess_kurtosis(_shapes(model, gradient), u)
    components = (
        _component(model, line, gradient, _u_and_dof(part)) for line, part in parts.items()
    )
    return Propagated(Estimate(model.value, u, dof, kurtosis=kurtosis), tuple(components))


def __getattr__(name: str) -> Any:
    return moved(__name__, name)


def sensitivities(model: MeasurementModel) -> Array:
    """Return the change of the measurand with each input, shape (n,).

    The derivative, where the equation knows it (5.1.3); else half of what it changes by from one
    standard uncertainty below to one above, over that uncertainty (JCGM 100, 5.1.3, note 2). An
    input without uncertainty has none.
    """
    count = len(model.inputs)
    if not count:
        return np.zeros(0)
    if isinstance(model.equation, Differentiable):
        at = {x.name: np.array([x.value]) for x in model.inputs}
        slopes = model.equation.gradient(at)
        return np.array(
            [
                float(np.ravel(slopes[x.name])[0]) if x.u != 0 and x.name in slopes else 0.0
                for x in model.inputs
            ]
        )
    values = np.array([x.value for x in model.inputs])
    u = np.array([UNKNOWN_STEP if isnan(x.u) else x.u for x in model.inputs])
    # One call for all trials: first each input above its estimate in turn, then each below.
    steps = np.concatenate([np.diag(u), -np.diag(u)]).reshape(2 * count, count)
    trials = dict(zip((x.name for x in model.inputs), (values + steps).T, strict=True))
    y: Array = np.broadcast_to(model.equation(trials), 2 * count)
    change = np.zeros(count)
    np.divide(y[:count] - y[count:], 2 * u, out=change, where=u > 0)
    return change


def connected(model: MeasurementModel) -> Sequence[Sequence[int]]:
    """Return the rows of inputs that are correlated or of one ensemble, each group in order."""
    groups: list[list[int]] = []
    for row in range(len(model.inputs)):
        # A row can join groups that nothing has linked so far.
        linked = [group for group in groups if any(_linked(model, row, other) for other in group)]
        groups = [group for group in groups if group not in linked]
        groups.append(sorted({row, *(other for group in linked for other in group)}))
    return groups


def one_error(model: MeasurementModel, rows: Sequence[int]) -> Array | None:
    """Return u of inputs with r = 1 or -1 that are one bounded error, with signs; else None.

    They have one shape: rectangles that are fully correlated add to a rectangle.
    """
    first = model.inputs[rows[0]]
    same_shape = all(
        (x.distribution, x.dof) == (first.distribution, first.dof)
        for x in (model.inputs[row] for row in rows)
    )
    if model.correlation is None or len(rows) == 1 or first.distribution not in KURTOSIS:
        return None
    r = model.correlation[np.ix_(rows, rows)]
    if not same_shape or np.any(np.abs(r) < 1):
        return None
    return np.asarray(np.array([model.inputs[row].u for row in rows]) * r[0])


def _linked(model: MeasurementModel, row: int, other: int) -> bool:
    one, two = model.inputs[row], model.inputs[other]
    correlated = model.correlation is not None and model.correlation[row, other] != 0
    return bool(correlated) or bool(one.ensemble and one.ensemble == two.ensemble)


def _shapes(model: MeasurementModel, gradient: Array) -> Iterator[tuple[float, str]]:
    """Yield independent contributions and their distributions; fully correlated inputs are one.

    Others that are correlated pass for normal: only of independent inputs do fourth cumulants add.
    """
    for rows in connected(model):
        error_u = one_error(model, rows)
        if error_u is not None:
            yield abs(float(gradient[list(rows)] @ error_u)), model.inputs[rows[0]].distribution
            continue
        for row in rows:
            x, c = model.inputs[row], gradient[row]
            alone = model.correlation is None or np.count_nonzero(model.correlation[row]) == 1
            yield abs(float(c)) * x.u, x.distribution if alone else Distribution.NORMAL


def _lines(model: MeasurementModel) -> Mapping[str, list[int]]:
    lines: dict[str, list[int]] = {}
    for row, x in enumerate(model.inputs):
        lines.setdefault(x.budget_line, []).append(row)
    return lines


def _uncertain_numbers(model: MeasurementModel) -> Sequence[Any]:
    """Return GTC's uncertain number of each input; those of an ensemble share their dof."""
    import GTC  # noqa: PLC0415  (0.6 s that only a propagation is to pay)

    # GTC correlates numbers of infinite dof only where they are declared as not independent.
    numbers: list[Any] = [
        None if isnan(x.u) else GTC.ureal(x.value, x.u, x.dof, independent=x.dof < inf)
        for x in model.inputs
    ]
    for ensemble in dict.fromkeys(x.ensemble for x in model.inputs if x.ensemble):
        rows = [row for row, x in enumerate(model.inputs) if x.ensemble == ensemble]
        inputs = [model.inputs[row] for row in rows]
        dof = inputs[0].dof
        if any(x.dof != dof for x in inputs):
            raise ValueError(f"the inputs of {ensemble} differ in their degrees of freedom")
        ensemble_numbers = GTC.multiple_ureal([x.value for x in inputs], [x.u for x in inputs], dof)
        for row, number in zip(rows, ensemble_numbers, strict=True):
            numbers[row] = number
    if model.correlation is not None:
        for i, j in combinations(range(len(numbers)), 2):
            r, one, other = float(model.correlation[i, j]), model.inputs[i], model.inputs[j]
            if r != 0 and one.u > 0 and other.u > 0:
                _refuse_without_dof(one, other)
                GTC.set_correlation(r, numbers[i], numbers[j])
    return numbers


def _refuse_without_dof(one: Input, other: Input) -> None:
    share_ensemble = one.ensemble and one.ensemble == other.ensemble
    infinite = one.dof == other.dof == inf and not (one.ensemble or other.ensemble)
    if not (share_ensemble or infinite):
        raise ValueError(
            f"{one.name} and {other.name} are correlated, but of degrees of freedom that they do "
            "not share: put them into one ensemble"
        )


def _combine(rows: Sequence[int], gradient: Array, numbers: Sequence[Any]) -> Any:
    import GTC  # noqa: PLC0415  (see above)

    # 0 times an uncertain number has nan degrees of freedom in GTC, which would reach the sum.
    contributing = [row for row in rows if gradient[row] != 0]
    return sum((float(gradient[row]) * numbers[row] for row in contributing), GTC.constant(0.0))


def _u_and_dof(number: Any) -> tuple[float, float]:
    """Return u and its degrees of freedom: infinite of what is certain, nan of what is unknown."""
    if number is None:
        return nan, nan
    return float(getattr(number, "u", 0.0)), float(getattr(number, "df", inf))


def _component(
    model: MeasurementModel, line: str, gradient: Array, u_and_dof: tuple[float, float]
) -> Component:
    rows = _lines(model)[line]
    first = model.inputs[rows[0]]
    u, dof = u_and_dof
    shown = Component(
        name=line,
        u=u,
        # A line that adds nothing has none in GTC; those of its input are shown.
        dof=first.dof if u == 0 else dof,
        distribution=str(first.distribution),
        common=first.common,
    )
    if len(rows) == 1:
        c = float(gradient[rows[0]])
        return replace(shown, value=first.value, unit=first.unit, input_u=first.u, sensitivity=c)
    total = model.lines.get(line, Line(nan))
    return replace(
        shown,
        value=total.value,
        input_u=u / abs(total.sensitivity),
        sensitivity=total.sensitivity,
    )
