"""Numbers with the digits that their uncertainty justifies."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, isfinite, isnan, log10
from typing import TYPE_CHECKING

from rigrunner.api.units import with_symbol
from rigrunner.signal.coverage import expanded, factor
from rigrunner.signal.rounding import places

if TYPE_CHECKING:
    from rigrunner.api import Estimate

MINUS = "\N{MINUS SIGN}"
TIMES = "\N{MULTIPLICATION SIGN}"
UNKNOWN = "unknown"
MANY_DOF = 1e4
"""Above these degrees of freedom, infinity is printed."""
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
LOWEST, HIGHEST = -3, 5
"""A number between these powers of ten, both exclusive, is written without one."""


@dataclass(frozen=True)
class Stated:
    """An estimate as printed: U has two significant digits, the value the same place."""

    value: str
    expanded: str
    factor: str
    unit: str

    @property
    def interval(self) -> str:
        """Value and expanded uncertainty, without the unit."""
        return f"{self.value} ± {self.expanded}"

    def __str__(self) -> str:
        """Return value, expanded uncertainty and unit."""
        return with_symbol(self.interval, self.unit)


def stated(estimate: Estimate) -> Stated:
    """Return the estimate as printed (rounding: GUM 7.2.6)."""
    width = expanded(estimate)
    digits = places(width)
    if not width > 0 or not isfinite(width):  # at least four significant digits of the value
        digits = max(digits, places(abs(estimate.value), 4))
    shown = fixed(width, digits) if isfinite(width) else UNKNOWN
    k = fixed(factor(estimate), 2)
    return Stated(fixed(estimate.value, digits), shown, k, estimate.unit)


def fixed(value: float, decimals: int) -> str:
    """Return a number with that many decimals (negative: rounded to tens, hundreds, ...)."""
    if isnan(value):
        return UNKNOWN
    if not isfinite(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    text = f"{round(value, decimals):.{max(decimals, 0)}f}"
    return _signed(text)


def with_sign(value: float, decimals: int) -> str:
    """Return a difference with that many decimals and its sign, also '+'."""
    text = fixed(value, decimals)
    return text if text.startswith(MINUS) or not isfinite(value) else f"+{text}"


def significant(value: float, digits: int = 4) -> str:
    """Return a number with that many significant digits, far from 1 with a power of ten."""
    if not isfinite(value):
        return fixed(value, 0)
    if value == 0:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if LOWEST < power < HIGHEST:
        return _signed(f"{value:.{max(digits - 1 - power, 0)}f}")
    return f"{_signed(mantissa)} {TIMES} 10{str(power).translate(SUPERSCRIPTS)}"


def with_standard_uncertainty(value: float, u: float, unit: str) -> str:
    """Return 'value ± u unit', u with two significant digits; '(value ± u) power unit'."""
    scale, power = _scale(value, u)
    digits = places(u * scale)
    text = f"{fixed(value * scale, digits)} ± {fixed(u * scale, digits)}"
    return f"({text}){power} {unit}" if power else f"{text} {unit}"


def to_place_of(value: float, u: float) -> str:
    """Return the value, rounded to the second significant digit of its standard uncertainty."""
    scale, power = _scale(value, u)
    return f"{fixed(value * scale, places(u * scale))}{power}"


def _scale(value: float, u: float) -> tuple[float, str]:
    """Return a factor and the power of ten that undoes it, as text, for the larger of both."""
    largest = max((abs(number) for number in (value, u) if isfinite(number)), default=0.0)
    power = floor(log10(largest)) if largest else 0
    if LOWEST < power < HIGHEST:
        return 1.0, ""
    return 10.0**-power, f" {TIMES} 10{str(power).translate(SUPERSCRIPTS)}"


def plain(value: float) -> str:
    """Return a set value with up to six significant digits, without trailing zeros: 35."""
    return _signed(f"{value:.6g}") if isfinite(value) else fixed(value, 0)


def _signed(text: str) -> str:
    if not text.startswith("-"):
        return text
    return text.removeprefix("-") if float(text) == 0 else text.replace("-", MINUS)


def as_scattered(value: float, deviation: float) -> str:
    """Return a value with one decimal more than its standard deviation justifies."""
    return fixed(value, max(0, places(deviation) + 1))


def percent(part: float, of: float) -> str:
    """Return a part of a whole in percent, with one decimal."""
    return fixed(100.0 * part / of, 1)
