"""What a calibration certificate says of an instrument: range, points, accuracy, conditions."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import BeforeValidator, Field, model_validator

from rigrunner.api.quantity import Quantity, parse_quantity
from rigrunner.api.settings import AnyQuantity, Ratio, Settings, Temperature, Torque
from rigrunner.api.units import QuantityError, si_symbol

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

_OF_FULL_SCALE = r"([0-9]+(?:\.[0-9]*)?|\.[0-9]+)\s*%\s*FS"
_EXAMPLE = "such as '0.5 % FS', the share of full scale"


class CalibratedRange(Settings):
    """Between which values the calibration holds, in the unit of the quantity that is measured."""

    min: AnyQuantity | None = None
    """Left out: of a torque transducer minus `max`, as it turns both ways; of others no bound."""
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
    """One line of the certificate's table: applied value, indication and uncertainty."""

    applied: AnyQuantity
    """What the standard put on the instrument."""
    indicated: AnyQuantity
    """What the instrument showed."""
    U: AnyQuantity
    """The expanded uncertainty of the calibration at this point."""
    k: Annotated[float, Field(gt=0)] = 2.0
    """The coverage factor that belongs to U (GUM 6.2)."""

    @model_validator(mode="after")
    def _one_dimension(self) -> Self:
        _same_dimension(self.indicated, self.applied.dimension, "indicated")
        _same_dimension(self.U, self.applied.dimension, "U")
        if difference(self.U) < 0:
            raise ValueError(f"got U = {self.U}, expected 0 or more")
        return self

    @property
    def deviation(self) -> float:
        """Indicated less applied, in the SI unit."""
        return self.indicated.si - self.applied.si

    @property
    def standard_uncertainty(self) -> float:
        """U / k, in the SI unit (GUM 4.3.3)."""
        return difference(self.U) / self.k


class TemperatureRange(Settings):
    """Between which temperatures."""

    min: Temperature
    """The lowest."""
    max: Temperature
    """The highest."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        _check_ascending(self.min, self.max)
        return self


class HumidityRange(Settings):
    """Between which relative humidities."""

    min: Ratio
    """The lowest."""
    max: Ratio
    """The highest."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        _check_ascending(self.min, self.max)
        return self


class CalibrationConditions(Settings):
    """In which surroundings the calibration holds."""

    temperature: TemperatureRange | None = None
    humidity: HumidityRange | None = None


class _TextOrMapping:
    """Tells editors that an accuracy is a text or a mapping."""

    def __get_pydantic_json_schema__(
        self, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        text = {"type": "string", "pattern": rf"^\s*{_OF_FULL_SCALE}\s*$"}
        return {"anyOf": [text, handler(core_schema)]}


class TorqueAccuracy(Settings):
    """Limits of error of a torque transducer, each half the width of a rectangular distribution."""

    gain: Annotated[Ratio, Field(ge=0)]
    """Of the reading."""
    offset: Annotated[Torque, Field(ge=0)]
    """Of the zero, before it is taken out by a zero step."""
    drift: Annotated[Torque, Field(ge=0)]
    """Of the zero, in the course of a run."""
    nonlinearity: Annotated[Ratio, Field(ge=0, description="of full scale")]
    of_full_scale: Annotated[
        Ratio, Field(ge=0, description="all errors in one figure, of full scale, not split further")
    ] = 0.0

    @classmethod
    def in_one_figure(cls, of_full_scale: float) -> TorqueAccuracy:
        """Return an accuracy of which no more is known than a share of full scale."""
        parts = {"gain": "0 %", "offset": "0 N·m", "drift": "0 N·m", "nonlinearity": "0 %"}
        whole = {"of_full_scale": Quantity(of_full_scale, parse_quantity("0 1").unit)}
        return cls.model_validate(parts | whole)


def _read_torque_accuracy(value: object) -> object:
    if not isinstance(value, str):
        return value
    found = re.fullmatch(rf"\s*{_OF_FULL_SCALE}\s*", value)
    if found is None:
        hint = f"{_EXAMPLE}, or a mapping of gain, offset, drift and nonlinearity"
        raise QuantityError(f"'{value[:40]}' is not an accuracy", hint=hint)
    return TorqueAccuracy.in_one_figure(float(found[1]) / 100)


StatedTorqueAccuracy = Annotated[
    TorqueAccuracy, BeforeValidator(_read_torque_accuracy), _TextOrMapping()
]
"""Split into its parts, or the text '0.5 % FS', which is taken as such."""


def _read_accuracy(value: object) -> object:
    """Check the text of an accuracy of any quantity: '0.5 % FS', '1 % reading' or '0.2 K'."""
    if not isinstance(value, str):
        raise QuantityError("an accuracy is a text", hint=f"{_EXAMPLE}, or '0.2 K'")
    if not re.fullmatch(rf"\s*{_OF_FULL_SCALE}\s*|\s*[0-9.]+\s*%\s*reading\s*", value):
        difference(parse_quantity(value))
    return value.strip()


Accuracy = Annotated[str, BeforeValidator(_read_accuracy)]
"""Limits of error of any instrument, as its data sheet states them."""


def limit_of_error(accuracy: str, value: float, full_scale: float) -> float:
    """Return what an `Accuracy` allows at a value, in the SI unit as the value and full scale."""
    share = re.fullmatch(r"\s*([0-9.]+)\s*%\s*(FS|reading)\s*", accuracy)
    if share is None:
        return difference(parse_quantity(accuracy))
    of = full_scale if share[2] == "FS" else value
    return float(share[1]) / 100 * abs(of)


def difference(quantity: Quantity) -> float:
    """Return a difference or a width in the SI unit; raise QuantityError for '0.2 °C'.

    A temperature in °C has another zero than K, so a width in °C would be read as 273 K more.
    """
    if quantity.unit.offset:
        si = si_symbol(quantity.dimension)
        message = f"'{quantity}' is a temperature, not a difference of two"
        raise QuantityError(message, hint=f"write it as '{quantity.number:g} {si}'")
    return quantity.si


def _check_ascending(lowest: float, highest: float) -> None:
    if lowest >= highest:
        raise ValueError("min must be below max")


def _same_dimension(quantity: Quantity, wanted: str, name: str) -> None:
    if quantity.dimension != wanted:
        raise ValueError(f"{name} is '{quantity}', a {quantity.dimension}; needed is a {wanted}")
