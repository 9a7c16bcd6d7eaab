"""The accuracy of an instrument of any quantity, error by error.

An error has limits and a distribution (GUM 4.3.7, JCGM 101:2008, 6.4). Names are those of VIM 4 and
of standards on transducers (DIN 51309, VDI/VDE 2646, ISO 376).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from math import inf, sqrt
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from pydantic import BeforeValidator, Field

from rigrunner.api.calibration import difference
from rigrunner.api.quantity import NUMBER, parse_quantity
from rigrunner.api.settings import Difference, PlainText, Settings
from rigrunner.api.units import QuantityError, of_difference, si_symbol, with_article

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

Shape = Literal["rectangular", "triangular", "arcsine", "normal"]
Acts = Literal["gain", "offset", "each"]
OVER_U: Mapping[str, float] = {
    "rectangular": sqrt(3),
    "triangular": sqrt(6),
    "arcsine": sqrt(2),
    "normal": 2.0,
}
"""Half-width divided by standard uncertainty; for `normal` the limit is U with k = 2."""
_SHARE = re.compile(rf"\s*({NUMBER})\s*(%|ppm|ppb)\s*(FS|reading)\s*")
_PARTS = {"%": 100, "ppm": 1e6, "ppb": 1e9}
_EXAMPLES = "such as '0.5 % FS', the share of full scale, '1 % reading' or '0.2 K'"
_EXPECTED = f"expected a limit of error with its unit, {_EXAMPLES}; or a mapping"
"""Message of editors, which would list types for an anonymous alternative."""
MOST_OF_SOURCE = 80
"""In characters."""
_OF_POINTS = ("overall", "gain", "offset", "nonlinearity")


@dataclass(frozen=True)
class ReadingError:
    """One error of a reading, from the register."""

    name: str
    """Name, such as 'gain of meter.resistance'."""
    acts: Acts
    """`gain`: the same relative error of all readings. `offset`: the same error of all readings.
    `each`: independent limits at each reading; the share common to two readings is unknown."""
    u: float
    """Standard uncertainty, in the SI unit of the channel; of a gain, relative."""
    dof: float = inf
    distribution: Shape | Literal["t"] = "rectangular"
    source: str = ""
    """Source of the value; '' if not stated."""

    def at(self, value: float) -> float:
        """Return the standard uncertainty of a reading of that value, in the SI unit."""
        return self.u * abs(value) if self.acts == "gain" else self.u


def _read_limit(value: object) -> object:
    if not isinstance(value, str):
        raise QuantityError("a limit of error is a text", hint=_EXAMPLES)
    share = _SHARE.fullmatch(value)
    if difference(parse_quantity(f"{share[1]} {share[2]}" if share else value)) < 0:
        raise QuantityError(f"got '{value.strip()}', expected 0 or more")
    return value.strip()


LimitText = Annotated[str, BeforeValidator(_read_limit)]
"""A limit of error as in a data sheet: '0.5 % FS', '1 % reading' or '0.2 K'."""


class HalfWidth(NamedTuple):
    """Half-width of a distribution: a part relative to the reading, and a part in the SI unit."""

    of_reading: float
    absolute: float


class ErrorLimit(Settings):
    """One error: its limit, its distribution, and the source."""

    limit: LimitText
    """'0.1 % reading', '0.02 % FS' or a difference such as '0.2 K'; means ± this value."""
    distribution: Shape = "rectangular"
    """For `normal` the limit is two standard uncertainties, for the others the half-width."""
    source: Annotated[PlainText, Field(max_length=MOST_OF_SOURCE)] = ""
    """The certificate or data sheet."""

    @property
    def described(self) -> str:
        """The limit as text."""
        return self.limit

    def in_parts(self, full_scale: float) -> HalfWidth:
        """Return both parts of the limit, for an instrument of that full scale in the SI unit."""
        share = _SHARE.fullmatch(self.limit)
        if share is None:
            return HalfWidth(0.0, difference(parse_quantity(self.limit)))
        part = float(share[1]) / _PARTS[share[2]]
        return HalfWidth(part, 0.0) if share[3] == "reading" else HalfWidth(0.0, part * full_scale)

    def half_width(self, value: float, full_scale: float) -> float:
        """Return the limit at a value, all in the SI unit."""
        of_reading, absolute = self.in_parts(full_scale)
        return of_reading * abs(value) + absolute


class TemperatureLimit(ErrorLimit):
    """An error that is proportional to a temperature difference."""

    per: Difference
    """Temperature difference for which the limit is stated, such as 10 K."""
    within: Difference
    """Greatest temperature difference: from the calibration, or since the zero reading."""

    @property
    def described(self) -> str:
        """The limit as text."""
        return f"{self.limit} per {self.per}, within {self.within}"

    def in_parts(self, full_scale: float) -> HalfWidth:
        """Return the two parts of the limit at `within`."""
        times = self.within.si / self.per.si
        of_reading, absolute = super().in_parts(full_scale)
        return HalfWidth(times * of_reading, times * absolute)


def described(name: str, limit: ErrorLimit) -> str:
    """Return the limit of an error as text; a resolution is a step, and has no sign."""
    return limit.described if name == "resolution" else f"±{limit.described}"


class _TextOrMapping:
    """JSON Schema for an error or an accuracy, which is a text or a mapping."""

    def __get_pydantic_json_schema__(
        self, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        text = {"type": ["string"], "errorMessage": _EXPECTED}
        return {"anyOf": [text, handler(core_schema)]}


def _limit(value: object) -> object:
    if isinstance(value, int | float) and not isinstance(value, bool):
        raise QuantityError(f"{value} is not a number with a unit", hint=_EXAMPLES)
    return {"limit": value} if isinstance(value, str) else value


def _share_of(base: str, value: object) -> object:
    """Read a bare percentage, such as '0.3 %', as relative to the reading or to full scale."""
    entry = _limit(value)
    limit = entry.get("limit") if isinstance(entry, dict) else None
    if not isinstance(limit, str) or _SHARE.fullmatch(limit):
        return entry
    quantity = parse_quantity(limit)
    if quantity.dimension != "ratio":
        return entry
    # As written, where possible: 100 times the SI value can differ in the last digit.
    symbol, number = quantity.unit.symbol, quantity.number
    share = f"{number!r} {symbol}" if symbol in _PARTS else f"{100 * quantity.si!r} %"
    return {**entry, "limit": f"{share} {base}"}  # type: ignore[dict-item]  # a dict


def _in_one_figure(value: object) -> object:
    return {"overall": {"limit": _read_limit(value)}} if isinstance(value, str) else _limit(value)


StatedLimit = Annotated[ErrorLimit, BeforeValidator(_limit), _TextOrMapping()]
"""A mapping, or the limit alone."""
StatedGain = Annotated[ErrorLimit, BeforeValidator(partial(_share_of, "reading")), _TextOrMapping()]
StatedNonlinearity = Annotated[
    ErrorLimit, BeforeValidator(partial(_share_of, "FS")), _TextOrMapping()
]


class Accuracy(Settings):
    """Errors of an instrument, each with its limit; an omitted error is zero."""

    overall: StatedLimit | None = None
    """One limit for all errors; an accuracy given as text is this."""
    gain: StatedGain | None = None
    """Error of the sensitivity: relative to the reading, the same for all readings."""
    offset: StatedLimit | None = None
    """Error of the zero: the same for all readings, removed by a zero reading."""
    drift: StatedLimit | None = None
    """Drift since the calibration, or since the zero reading."""
    nonlinearity: StatedNonlinearity | None = None
    """Deviation from a straight line; a bare percentage is of full scale."""
    repeatability: StatedLimit | None = None
    """Scatter of readings of the same value: half of their range, b' of DIN 51309."""
    hysteresis: StatedLimit | None = None
    """Difference between rising and falling values: half of it, h of DIN 51309."""
    resolution: StatedLimit | None = None
    """Smallest step of the reading, r; the error is up to half of it."""
    creep: StatedLimit | None = None
    """Change under a constant load."""
    temperature: TemperatureLimit | None = None
    """Effect of the ambient temperature, on zero and sensitivity together."""
    temperature_zero: TemperatureLimit | None = None
    """Effect of the temperature on the zero (TK0)."""
    temperature_sensitivity: TemperatureLimit | None = None
    """Effect of the temperature on the sensitivity (TKC)."""

    @property
    def limits(self) -> dict[str, ErrorLimit]:
        """The stated errors by name."""
        return {name: limit for name, limit in self if limit is not None}

    @property
    def has_calibration(self) -> bool:
        """Whether it states errors that calibration points would give too."""
        return any(name in self.limits for name in _OF_POINTS)

    def half_width(self, name: str, value: float, full_scale: float) -> float:
        """Return the limit of one error at a value, in the SI unit; of a gain, relative.

        0 if not stated; half the step for a resolution.
        """
        limit = self.limits.get(name)
        if limit is None:
            return 0.0
        width = limit.half_width(1.0 if name == "gain" else value, full_scale)
        return width / 2 if name == "resolution" else width

    def limit_of_error(self, value: float, full_scale: float) -> float:
        """Return the greatest error of a reading at a value: all errors at their limits."""
        return sum(
            self.half_width(name, value, full_scale) * (abs(value) if name == "gain" else 1.0)
            for name in self.limits
        )

    def errors(self, channel: str, value: float, full_scale: float) -> Iterator[ReadingError]:
        """Yield each error at a value; all in the SI unit."""
        for name, limit in self.limits.items():
            width = self.half_width(name, value, full_scale)
            share, absolute = limit.in_parts(full_scale)
            # A limit such as '0.2 N·m' is no share of the reading, and cannot act as a gain.
            is_gain = name == "gain" or (name == "temperature_sensitivity" and absolute == 0)
            yield ReadingError(
                name=f"{'reading' if name == 'overall' else name.replace('_', ' ')} of {channel}",
                acts="gain" if is_gain else "offset" if name == "offset" else "each",
                u=(share if is_gain else width) / OVER_U[limit.distribution],
                distribution=limit.distribution,
                source=limit.source,
            )

    def objections(self, quantity: str) -> Iterator[str]:
        """Yield each limit that does not fit the quantity."""
        for name, limit in self.limits.items():
            path = "" if name == "overall" else f"{name}: "
            if name == "gain" and of_difference(quantity) != quantity:
                yield f"{path}got '{limit.limit}', expected an 'offset' in dB"
            elif name == "gain" and not limit.limit.endswith("reading"):
                yield f"{path}got '{limit.limit}', expected a share, such as '0.3 %'"
            elif problem := _problem_with(limit.limit, quantity):
                yield f"{path}got '{limit.limit}'{problem}"

    def shares_of_full_scale(self) -> dict[str, str]:
        """Return the limits relative to full scale by name, without the overall one."""
        limits = {name: limit.limit for name, limit in self.limits.items() if name != "overall"}
        return {name: limit for name, limit in limits.items() if limit.endswith("FS")}


def _problem_with(limit: str, quantity: str) -> str:
    """Return what is wrong with a limit for that quantity; '' for nothing."""
    difference_kind = of_difference(quantity)
    has_scale = quantity == "temperature" or difference_kind != quantity  # 0 of it is not nothing
    share = _SHARE.fullmatch(limit)
    if share and has_scale:
        return f", expected a difference in {si_symbol(difference_kind)}"
    kind = "" if share else parse_quantity(limit).dimension
    if share or kind == difference_kind:
        return ""
    if kind == quantity:
        return f", {with_article(kind)}, expected a difference in {si_symbol(difference_kind)}"
    if kind == "ratio":
        return ", which does not say of what: write '% FS' or '% reading'"
    return f", {with_article(kind)}, expected {with_article(quantity)}"


StatedAccuracy = Annotated[Accuracy, BeforeValidator(_in_one_figure), _TextOrMapping()]
"""Error by error, or one limit for all as text, such as '0.1 % FS'."""
