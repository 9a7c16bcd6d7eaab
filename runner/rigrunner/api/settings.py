"""Base class of the settings of plugins, and field types that read quantities with units.

`load: Force` reads the text '1000 N' from YAML and holds 1000.0 (SI). A number without its unit is
refused. In Python, pass a text or a `Quantity`.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Protocol, TypeVar, runtime_checkable

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

from rigrunner.api.quantity import Quantity, parse_quantity, quantity_pattern
from rigrunner.api.texts import plain
from rigrunner.api.units import QuantityError, unit, units_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

_KINDS: Mapping[type, str] = {dict: "a mapping", list: "a list", bool: "yes or no"}
_YES_NO = {"yes": True, "no": False}


class Settings(BaseModel):
    """Frozen, strict, no unknown keys: base class of every model that is read from YAML.

    A model is built when it is first used, since most commands use few of the models that they
    import.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, defer_build=True)


SettingsT = TypeVar("SettingsT", bound=Settings)


def own_keys(model: type[SettingsT], keys: Mapping[str, Any]) -> SettingsT:
    """Return the settings of the keys of this model; other keys belong to other plugins.

    Raises pydantic.ValidationError if a value is wrong.
    """
    return model.model_validate({k: v for k, v in keys.items() if k in model.model_fields})


@runtime_checkable
class Reached(Protocol):
    """Settings with the address of an instrument, which only one run at a time may use."""

    def physical_addresses(self) -> Sequence[str]:
        """Return each address of the instrument, without contacting it.

        'serial:/dev/ttyUSB0', 'tcp:192.0.2.7:5025', 'tcp:192.0.2.7:502/unit 3' for one behind a
        gateway, 'visa:GPIB0::12::INSTR', or any other 'kind:name'. Different spellings of one
        address are recognised: links to a serial port, names and numbers of a host.
        """
        ...


class MadeOfOthers(Settings):
    """Base class of the settings of a composite device; see `DeviceContext.make`."""

    def others(self) -> Mapping[tuple[str, ...], WrapperSettings]:
        """Return the parts, each by its key in the settings."""
        raise NotImplementedError

    def source(self, channel: str) -> tuple[WrapperSettings, str] | None:
        """Return the part that provides a channel and its name there; None if no part does."""
        raise NotImplementedError


class WrapperSettings(MadeOfOthers):
    """Base class of the settings of a device that wraps another one."""

    plugin: Annotated[
        str,
        Field(description="plugin of the inner device", json_schema_extra={"x-plugin": "device"}),
    ]
    settings: Annotated[dict[str, Any], Field(description="settings of the inner device")] = Field(
        default_factory=dict
    )

    def others(self) -> Mapping[tuple[str, ...], WrapperSettings]:
        """Return the wrapped device."""
        return {(): self}

    def source(self, channel: str) -> tuple[WrapperSettings, str] | None:
        """Return the wrapped device and the name."""
        return self, channel


def _read(dimension: str | None, value: object) -> Quantity:
    if isinstance(value, Quantity):
        value = str(value)  # so that its kind and size are checked too
    if isinstance(value, str):
        return parse_quantity(value, dimension)
    such_as = f"10 {units_of(dimension)[0]}" if dimension else "10 Hz"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        hint = f"such as '{such_as}'; a number without a unit is written '{value} 1'"
        if dimension:
            # A bare 0.3 is 0.3 % at least as often as 30 %.
            first, *others = units_of(dimension)
            units = [first] if first != "1" else [*others, first]
            hint = "write it as " + " or ".join(f"'{value} {symbol}'" for symbol in units)
        raise QuantityError(f"{value} is not a number with a unit", hint=hint)
    what = "nothing" if value is None else _KINDS.get(type(value), f"a {type(value).__name__}")
    raise QuantityError(f"got {what}, expected a number with a unit", hint=f"such as '{such_as}'")


def _difference(quantity: Quantity) -> Quantity:
    if quantity.unit.offset:
        hint = f"write it in K: '{quantity.number * quantity.unit.factor:.6g} K'"
        raise QuantityError(f"'{quantity}' is a temperature, not a difference of two", hint=hint)
    if quantity.si <= 0:
        raise QuantityError(f"got '{quantity}', expected more than 0")
    return quantity


def _read_yes_no(value: object) -> bool:
    if isinstance(value, bool):
        return value
    if isinstance(value, str) and value in _YES_NO:
        return _YES_NO[value]
    raise ValueError(f"got {str(value)[:20]!r}, expected yes or no")


def _symbol(text: str) -> str:
    return unit(text).symbol


def _read_date(value: object) -> object:
    if not isinstance(value, str):
        return value
    try:
        return date.fromisoformat(value)
    except ValueError as error:
        raise ValueError(f"'{value[:20]}' is not a date; write it as 2026-01-31") from error


@dataclass(frozen=True)
class QuantitySchema:
    """JSON Schema of a quantity, with the units known at that time."""

    dimension: str | None
    """The kind of quantity; None for any."""

    def __get_pydantic_json_schema__(
        self, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        dimension = self.dimension
        units = ", ".join(units_of(dimension)) if dimension else "such as '10 Hz'"
        return {
            "type": "string",
            "pattern": quantity_pattern(dimension),
            "description": f"{dimension} in {units}" if dimension else "number with its unit",
            "errorMessage": f"expected a number with its unit: {units}",
            "x-dimension": dimension,
        }


def _field(dimension: str) -> tuple[BeforeValidator, QuantitySchema]:
    return BeforeValidator(lambda value: _read(dimension, value).si), QuantitySchema(dimension)


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
Voltage = Annotated[float, *_field("voltage")]
VoltageRatio = Annotated[float, *_field("voltage ratio")]

YesNo = Annotated[
    bool, BeforeValidator(_read_yes_no), WithJsonSchema({"enum": ["yes", "no", True, False]})
]
"""A yes or no; the only type for which the texts 'yes' and 'no' are values."""

PlainText = Annotated[str, AfterValidator(plain)]
"""A text for people, without invisible characters."""

UnitSymbol = Annotated[str, AfterValidator(_symbol)]
"""A unit such as mV, by its symbol."""

IsoDate = Annotated[date, BeforeValidator(_read_date)]
"""A date such as 2026-01-31."""

Item = TypeVar("Item")
# Not strict, as YAML gives a list, and strictly that is no tuple.
ListOf = Annotated[tuple[Item, ...], Field(strict=False)]
"""A list in YAML, stored as a tuple: `ListOf[Frequency]`."""


def _several(value: object) -> object:
    return value if isinstance(value, list | tuple) else [value]


class _ItemOrList:
    """Allows a single item in place of a list, in the schema."""

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        listed = handler(core)
        return {"anyOf": [listed["items"], listed]}


OneOrSeveral = Annotated[
    tuple[Item, ...], BeforeValidator(_several), Field(strict=False), _ItemOrList()
]
"""One value, or a list of values."""

PositiveDuration = Annotated[Duration, Field(gt=0)]
AnyQuantity = Annotated[Quantity, BeforeValidator(partial(_read, None)), QuantitySchema(None)]
Difference = Annotated[AnyQuantity, AfterValidator(_difference)]
"""A difference of two values: greater than zero, temperatures in K."""


class SimulableSettings(Settings):
    """Base class of the settings of a device with a simulator of its instrument.

    If all devices of a station are simulated, time is simulated too, and the values are not taken
    for measurements.
    """

    simulated: YesNo = False
    """Whether to use the simulator in place of the instrument."""
