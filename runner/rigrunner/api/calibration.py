"""Data of a calibration certificate: range, points, conditions."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api.settings import AnyQuantity, Ratio, Settings, Temperature
from rigrunner.api.units import QuantityError, of_difference, si_symbol, with_article

if TYPE_CHECKING:
    from rigrunner.api.quantity import Quantity


class CalibratedRange(Settings):
    """Range for which the calibration is valid, in the unit of the measured quantity."""

    min: AnyQuantity | None = None
    """If omitted, minus `max` for a torque transducer, which is symmetrical, and no bound for
    others."""
    max: AnyQuantity
    """The highest value."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if self.min is None:
            return self
        _same_dimension(self.min, self.max.dimension, "min")
        if self.min.si >= self.max.si:
            raise ValueError(f"min ({self.min}) must be below max ({self.max})")
        return self


class CalibrationPoint(Settings):
    """One line of the table of the certificate: applied value, indication and uncertainty."""

    applied: AnyQuantity
    """Value of the standard."""
    indicated: AnyQuantity
    """Indication of the instrument."""
    U: AnyQuantity
    """Expanded uncertainty of the calibration at this point."""
    k: Annotated[float, Field(gt=0)] = 2.0
    """Coverage factor of U (GUM 6.2)."""

    @model_validator(mode="after")
    def _one_dimension(self) -> Self:
        _same_dimension(self.indicated, self.applied.dimension, "indicated")
        if self.U.dimension != of_difference(self.applied.dimension):
            _same_dimension(self.U, self.applied.dimension, "U")
        if difference(self.U) < 0:
            raise ValueError(f"got U = {self.U}, expected 0 or more")
        return self

    @property
    def deviation(self) -> float:
        """Indicated minus applied, in the SI unit."""
        return self.indicated.si - self.applied.si

    @property
    def standard_uncertainty(self) -> float:
        """U / k, in the SI unit (GUM 4.3.3)."""
        return difference(self.U) / self.k

    @property
    def half_width(self) -> float:
        """Of a rectangle with that uncertainty or more: U, or √3 U / k if that is greater."""
        return max(self.k, sqrt(3)) * self.standard_uncertainty


class TemperatureRange(Settings):
    """A range of temperatures."""

    min: Temperature
    """The lowest."""
    max: Temperature
    """The highest."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        _check_ascending(self.min, self.max)
        return self


class HumidityRange(Settings):
    """A range of relative humidities."""

    min: Ratio
    """The lowest."""
    max: Ratio
    """The highest."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        _check_ascending(self.min, self.max)
        return self


class CalibrationConditions(Settings):
    """Ambient conditions for which the calibration is valid."""

    temperature: TemperatureRange | None = None
    humidity: HumidityRange | None = None


def difference(quantity: Quantity) -> float:
    """Return a difference or a width in the SI unit; raise QuantityError for '0.2 °C'.

    The zero of °C is not that of K, so a width in °C would be read as 273 K more.
    """
    if quantity.unit.offset:
        si = si_symbol(quantity.dimension)
        message = f"'{quantity}' is a temperature, not a difference of two"
        number = quantity.number * quantity.unit.factor
        raise QuantityError(message, hint=f"write it as '{number:.6g} {si}'")
    return quantity.si


def _check_ascending(lowest: float, highest: float) -> None:
    if lowest >= highest:
        raise ValueError("min must be below max")


def _same_dimension(quantity: Quantity, kind: str, name: str) -> None:
    if quantity.dimension != kind:
        raise ValueError(
            f"{name} is '{quantity}', {with_article(quantity.dimension)}; expected"
            f" {with_article(kind)}"
        )
