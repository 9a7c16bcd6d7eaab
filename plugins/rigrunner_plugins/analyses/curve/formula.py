"""The fitted curve as the report shows it: its formula, and its parameters with their units."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from math import floor, isfinite, log10, sqrt
from typing import TYPE_CHECKING

from rigrunner.api import unit
from rigrunner.api.findings import Formula, Table
from rigrunner.api.units import from_si
from rigrunner.signal.expression.syntax import ExpressionError, parse_any
from rigrunner.signal.rounding import places
from rigrunner_plugins.analyses.equation.text import RESERVED

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner_plugins.analyses.curve.derived import Fitted
    from rigrunner_plugins.analyses.curve.settings import CurveSettings

_SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹"
_POWER = re.compile(f"[{_SUPERSCRIPTS}]+")
_TO_DIGITS = str.maketrans(_SUPERSCRIPTS, "0123456789")
_TO_SUPERSCRIPTS = str.maketrans("-0123456789", f"⁻{_SUPERSCRIPTS}")
_ORIGIN = "origin"
"""Stands in the formula for the value from which x counts."""
MOST_POWERS = 10
MINUS, TIMES = "\N{MINUS SIGN}", "\N{MULTIPLICATION SIGN}"
MOST_DECIMALS = 12
PLAIN = 1e-3, 1e6
"""Values beyond these are written with a power of ten."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of the curve at one place, in the unit for display."""

    name: str
    value: float
    u: float
    unit: str

    @property
    def text(self) -> str:
        """The rounded value with its unit; a negative one in parentheses."""
        decimals = min(places(self.u), MOST_DECIMALS) if self.u > 0 else 6
        if self.value and not PLAIN[0] <= abs(self.value) < PLAIN[1]:
            digits = max(decimals + floor(log10(abs(self.value))), 0)
            number, _, power = f"{self.value:.{digits}e}".partition("e")
            number = f"{number} {TIMES} 10{_superscript(int(power))}"
        else:
            number = f"{round(self.value, decimals):.{max(decimals, 0)}f}"
        shown = f"{number.replace('-', MINUS)} {self.unit}".rstrip()
        return f"({shown})" if self.value < 0 else shown


def mathematics(
    curves: Sequence[tuple[str, Fitted]], settings: CurveSettings, of: str
) -> tuple[tuple[Formula, ...], tuple[Table, ...]]:
    """Return the formula of curves, which have their places, and a table of their parameters.

    Of a single curve there is the formula with the values too. All are shown with the result `of`.
    There are none of a curve that is no formula, such as an interpolation.
    """
    formulas = _formulas(curves[0][1], settings, of)
    if not formulas:
        return (), ()
    return formulas[: 1 if len(curves) > 1 else 2], (_table(curves, settings, of),)


def _formulas(fitted: Fitted, settings: CurveSettings, of: str) -> tuple[Formula, ...]:
    """Return the curve with the names of its parameters, and with their values; or nothing."""
    _, _, right = fitted.curve.formula.partition(" = ")
    text = _POWER.sub(lambda match: f"**{match[0].translate(_TO_DIGITS)}", right).replace("·", "*")
    names = set(fitted.curve.names)
    try:
        regressors = parse_any(text).names() - names
    except ExpressionError:
        return ()
    if _ORIGIN in names:
        return ()
    quantities = {}
    if len(settings.over) == 1 and len(regressors) == 1:
        (x,), values = regressors, fitted.values
        x_name = next(iter(settings.over.values())).rpartition(".")[2]
        x_name = x if x_name in names | RESERVED | {_ORIGIN} else x_name
        if values.origin:
            quantities[_ORIGIN] = f"{from_si(values.origin, values.shown[0]):.6g} {values.shown[0]}"
        shifted = f"({x_name} - {_ORIGIN})" if values.origin else x_name
        text = re.sub(rf"\b{re.escape(x)}\b", shifted, text)
    symbol = settings.of.rpartition(".")[2]
    by_name = Formula(of=of, symbol=symbol, text=text, quantities=quantities, is_curve=True)
    texts = {parameter.name: parameter.text for parameter in parameters_of(fitted, settings)}
    return by_name, replace(by_name, quantities=quantities | texts)


def parameters_of(fitted: Fitted, settings: CurveSettings) -> Iterator[Parameter]:
    """Yield the parameters, each in its stated unit, or else in that of y over a power of x."""
    curve = fitted.curve
    powers = _powers(fitted)
    for place, name in enumerate(curve.names):
        result = settings.results.parameters.get(name)
        si = curve.units[place]
        symbol, factor = ("" if si == "1" else si), 1.0
        if result is not None:
            symbol, factor = result.unit, unit(result.unit).factor
        elif si in powers:
            symbol, factor = powers[si]
        u = sqrt(float(curve.covariance[place, place]))
        value = float(curve.coefficients[place])
        yield Parameter(name, value / factor, u / factor, symbol)


def _powers(fitted: Fitted) -> dict[str, tuple[str, float]]:
    """Return for each SI unit y/x^k the unit for display and its factor."""
    values = fitted.values
    points = values.points()
    y, factor = _of_differences(values.y_shown)
    powers = {points.y_unit: (y, factor)}
    if len(values.names) == 1 and points.x_unit:
        symbol, x_factor = _of_differences(values.shown[0])
        for power in range(1, MOST_POWERS):
            exponent = "" if power == 1 else _superscript(power)
            over = f"({symbol})" if {"·", "/"} & set(symbol) else symbol
            powers[f"{points.y_unit}/{points.x_unit}{exponent}"] = (
                f"{y or 1}/{over}{exponent}",
                factor / x_factor**power,
            )
    return powers


def _superscript(power: int) -> str:
    return str(power).translate(_TO_SUPERSCRIPTS)


def _of_differences(symbol: str) -> tuple[str, float]:
    """Return a unit for differences, with its factor: K for temperatures, '' for numbers."""
    unit_ = unit(symbol)
    if unit_.offset:
        return "K", 1.0
    return ("" if symbol == "1" else symbol), unit_.factor


def _table(curves: Sequence[tuple[str, Fitted]], settings: CurveSettings, of: str) -> Table:
    has_several = len(curves) > 1
    return Table(
        of=of,
        title="Parameters of the fit, with u from the scatter about the curve",
        columns=(*(("where",) if has_several else ()), "", "estimate", "u", "unit"),
        rows=tuple(
            (*((place,) if has_several else ()), parameter.name, *_shown(parameter), parameter.unit)
            for place, fitted in curves
            for parameter in parameters_of(fitted, settings)
        ),
    )


def _shown(parameter: Parameter) -> tuple[float | str, float | str]:
    if not (isfinite(parameter.u) and parameter.u > 0):
        return parameter.value, "none" if parameter.u == 0 else "unknown"
    return round(parameter.value, places(parameter.u, 3)), float(f"{parameter.u:.3g}")
