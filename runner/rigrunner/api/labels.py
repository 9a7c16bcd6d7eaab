"""Labels of steps in a file, which become coordinates of recordings and rows."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema

from rigrunner.api.member import NAME
from rigrunner.api.names import valid_name
from rigrunner.api.quantity import Quantity, parse_quantity
from rigrunner.api.texts import plain
from rigrunner.api.units import QuantityError

if TYPE_CHECKING:
    from rigrunner.api.coordinates import Coordinate

RESERVED = frozenset({"cycles", "elapsed", "name", "recording", "utc"})
"""Names of columns that tables have anyway."""
_LONGEST = 80
# '60 sec' and '1,5s' are refused as mistyped quantities; 'V1.2', '3a' and a date stay texts.
_MEANT_AS_QUANTITY = re.compile(r"[^\w\s]?[0-9][0-9.,]*\s+\S|[^\w\s]?[0-9]+[.,][0-9]+[^\d.,\s-]")


def _name(text: str) -> str:
    if "." in text:
        raise ValueError(f"'{text[:40]}' names a set-point; a label has a name without a dot")
    if valid_name(text) in RESERVED:
        raise ValueError(f"tables have a column '{text}' already; choose another name")
    return text


def _value(value: object) -> Quantity | Coordinate:
    if isinstance(value, bool | Quantity):
        return value
    if isinstance(value, int | float):
        return float(value)
    if not isinstance(value, str) or not value.strip():
        allowed = "a text, a number, true or false, or a quantity such as '60 s'"
        raise ValueError(
            f"got {'nothing' if value is None else 'no such value'}, expected {allowed}"
        )
    if len(value) > _LONGEST:
        raise ValueError(f"a text of {len(value)} characters, expected at most {_LONGEST}")
    try:
        return parse_quantity(value)
    except QuantityError:
        if _MEANT_AS_QUANTITY.match(value.strip()):
            raise
    return plain(value)


CoordinateName = Annotated[
    str, AfterValidator(_name), Field(json_schema_extra={"pattern": f"^{NAME}$"})
]
"""The name of a counter or a label."""
LabelValue = Annotated[
    Any,
    BeforeValidator(_value),
    WithJsonSchema({"anyOf": [{"type": kind} for kind in ("string", "number", "boolean")]}),
]
"""A text, a float, a boolean or a Quantity. A text that is a quantity is read as one."""
Labels = Annotated[
    dict[CoordinateName, LabelValue],
    Field(
        description="Labels by name, which recordings and rows of this step and of the steps"
        " within it carry. A label is a text, a number, true or false, or a quantity.",
    ),
]
