"""What the readings of an instrument may be off by, of any quantity, error by error.

An error is known by its limits and its distribution (GUM 4.3.7, JCGM 101:2008, 6.4).
"""

from __future__ import annotations

from math import nan, sqrt
from typing import TYPE_CHECKING, Annotated

from pydantic import BeforeValidator, Discriminator, Field, Tag

from rigrunner.api.calibration import Accuracy, limit_of_error
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.reading_errors import ReadingError, Shape
from rigrunner.api.settings import Difference, PlainText, Settings
from rigrunner.api.units import with_article

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

OVER_U: Mapping[str, float] = {
    "rectangular": sqrt(3),
    "triangular": sqrt(6),
    "arcsine": sqrt(2),
    "normal": 2.0,
}
"""Half-width over standard uncertainty; of the normal one the limit is U with k = 2."""


class _TextOrMapping:
    """Tells editors that an error is a text or a mapping."""

    def __get_pydantic_json_schema__(
        self, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"type": "string"}, handler(core_schema)]}


class ErrorLimit(Settings):
    """One error: its limit, how it is distributed within, and who says so."""

    limit: Accuracy
    """'0.1 % reading', '0.02 % FS' or a difference such as '0.2 K': it is within ± this."""
    distribution: Shape = "rectangular"
    """Of `normal` the limit is two standard uncertainties, of the others the half-width."""
    source: Annotated[PlainText, Field(max_length=80)] = ""
    """The certificate or data sheet that states it."""

    def half_width(self, value: float, full_scale: float) -> float:
        """Return the limit at a value, all in the SI unit."""
        return limit_of_error(self.limit, value, full_scale)


class TemperatureLimit(ErrorLimit):
    """An error that grows with the temperature."""

    per: Difference
    """For how much warmer the limit is stated, such as 10 K."""
    within: Difference
    """How far the temperature may be away from that of the calibration."""

    def half_width(self, value: float, full_scale: float) -> float:
        """Return the limit over `within`."""
        return super().half_width(value, full_scale) * self.within.si / self.per.si


def misread(limit: str, dimension: str) -> str:
    """Return what is wrong with a limit of error of that quantity, after 'is'; '' if nothing."""
    if limit.endswith(("FS", "reading")):
        on_a_scale = dimension != "temperature"
        return "" if on_a_scale else f"'{limit}'; of a temperature it is a difference in K"
    found = parse_quantity(limit).dimension
    if found == dimension:
        return ""
    if found == "ratio":
        return f"'{limit}', and does not say of what: write '% FS' or '% reading'"
    return f"'{limit}', {with_article(found)}; measured is {with_article(dimension)}"


def _limit(value: object) -> object:
    return {"limit": value} if isinstance(value, str) else value


def _share(value: object) -> object:
    """Read a gain: '0.3 %' is of the reading."""
    read = _limit(value)
    limit = read.get("limit") if isinstance(read, dict) else None
    if isinstance(limit, str) and "reading" not in limit and limit.rstrip().endswith("%"):
        return {**read, "limit": f"{limit.rstrip()} reading"}  # type: ignore[dict-item]  # a dict
    return read


StatedLimit = Annotated[ErrorLimit, BeforeValidator(_limit), _TextOrMapping()]
"""As a mapping, or the limit alone."""
StatedGain = Annotated[ErrorLimit, BeforeValidator(_share), _TextOrMapping()]


class AccuracyInParts(Settings):
    """The errors of an instrument, each with its limit; what is left out adds nothing."""

    gain: StatedGain | None = None
    """Of the sensitivity: a share of the reading, the same for all readings."""
    offset: StatedLimit | None = None
    """The same for all readings."""
    resolution: StatedLimit | None = None
    """The smallest step of the reading: it may be off by half of that."""
    repeatability: StatedLimit | None = None
    """Between readings of the same value."""
    nonlinearity: StatedLimit | None = None
    """Off the straight line."""
    hysteresis: StatedLimit | None = None
    """Between rising and falling values: half of the difference."""
    drift: StatedLimit | None = None
    """Since the calibration."""
    temperature: TemperatureLimit | None = None
    """With the temperature of the surroundings."""

    @property
    def limits(self) -> dict[str, ErrorLimit]:
        """The errors that are stated, by their names."""
        return {name: each for name, each in self if each is not None}

    def objections(self, *, has_full_scale: bool) -> Iterator[str]:
        """Yield what is wrong with how the limits are stated."""
        if not self.limits:
            yield f"accuracy is empty: give one of {', '.join(type(self).model_fields)}"
        for name, each in self.limits.items():
            if name == "gain" and not each.limit.endswith("reading"):
                yield f"accuracy.gain is '{each.limit}'; needed is a share, such as '0.3 %'"
            elif each.limit.endswith("FS") and not has_full_scale:
                yield f"accuracy.{name} is '{each.limit}', and no 'range' says what full scale is"

    def limit_of_error(self, value: float, full_scale: float = nan) -> float:
        """Return what a reading of a value may be off by at most: all errors at their limits."""
        widths = {n: each.half_width(value, full_scale) for n, each in self.limits.items()}
        return sum(_half_of_step(name, width) for name, width in widths.items())

    def errors(self, channel: str, value: float, full_scale: float) -> Iterator[ReadingError]:
        """Yield a line for each error, at a value; all in the SI unit."""
        for name, each in self.limits.items():
            width = each.half_width(1.0 if name == "gain" else value, full_scale)
            yield ReadingError(
                name=f"{name} of {channel}",
                acts="gain" if name == "gain" else "offset" if name == "offset" else "each",
                u=_half_of_step(name, width) / OVER_U[each.distribution],
                distribution=each.distribution,
                source=each.source,
            )


def _half_of_step(name: str, width: float) -> float:
    return width / 2 if name == "resolution" else width


def _kind(value: object) -> str:
    return "parts" if isinstance(value, dict | AccuracyInParts) else "text"


AnyAccuracy = Annotated[
    Annotated[Accuracy, Tag("text")] | Annotated[AccuracyInParts, Tag("parts")],
    Discriminator(_kind),
]
"""In one figure, such as '0.1 % FS', or error by error."""
