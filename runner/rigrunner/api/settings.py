"""The base of every plugin's settings, and field types that read quantities with units.

`load: Force` takes the text '1000 N' from YAML and holds 1000.0 (SI). A bare number is refused: a
number without its unit is how rigs get broken. From Python give a text or a `Quantity`.
"""

from __future__ import annotations

from functools import partial
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, WithJsonSchema

from rigrunner.api.quantity import Quantity, QuantityError, parse_quantity, units_of


class Settings(BaseModel):
    """Frozen, strict, no unknown keys: the base of every model that is read from YAML."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


def _read(dimension: str | None, value: object) -> Quantity:
    if isinstance(value, Quantity):
        value = str(value)
    if not isinstance(value, str):
        example = units_of(dimension)[0] if dimension else "Hz"
        raise QuantityError(
            f"{value!r} is not a number with a unit", hint=f"write it as '{value} {example}'"
        )
    return parse_quantity(value, dimension)


def _read_si(dimension: str, value: object) -> float:
    return _read(dimension, value).si


def _schema(dimension: str) -> WithJsonSchema:
    units = ", ".join(units_of(dimension))
    return WithJsonSchema(
        {"type": "string", "description": f"A {dimension} with its unit: {units}"}
    )


def _field(dimension: str) -> tuple[BeforeValidator, WithJsonSchema]:
    return BeforeValidator(partial(_read_si, dimension)), _schema(dimension)


Torque = Annotated[float, *_field("torque")]
Force = Annotated[float, *_field("force")]
Frequency = Annotated[float, *_field("frequency")]
Angle = Annotated[float, *_field("angle")]
Duration = Annotated[float, *_field("time")]
Length = Annotated[float, *_field("length")]
Ratio = Annotated[float, *_field("ratio")]
Temperature = Annotated[float, *_field("temperature")]
MomentOfInertia = Annotated[float, *_field("moment of inertia")]
RotationalDamping = Annotated[float, *_field("rotational damping")]
AngularVelocity = Annotated[float, *_field("angular velocity")]
FrequencyRate = Annotated[float, *_field("frequency rate")]
ForceRate = Annotated[float, *_field("force rate")]

AnyQuantity = Annotated[
    Quantity,
    BeforeValidator(partial(_read, None)),
    WithJsonSchema({"type": "string", "description": "A number with its unit, such as '10 Hz'"}),
]
