"""What a property of PyMeasure gives, as a number."""

from __future__ import annotations

from typing import Any, SupportsFloat

import numpy as np

from rigrunner.api import DeviceRejectedError
from rigrunner_plugins.devices.text.numbers import OVERLOAD, shown


def number_of(value: object, name: str, item: int | None = None) -> float:
    """Return a property's value, or one of several, as a number; raise DeviceRejectedError."""
    one = _one_of(value, name, item)
    if not isinstance(one, SupportsFloat):
        raise DeviceRejectedError(
            f"the property {name} gives {shown(str(one))}, which is not a number"
        )
    number = float(one)
    if not abs(number) < OVERLOAD:
        raise DeviceRejectedError(
            f"the property {name} gives {number:g}: overload or 'not a number'",
            hint="choose a larger range, or look at the wiring",
        )
    return number


def _one_of(value: Any, name: str, item: int | None) -> object:
    if not isinstance(value, (list, tuple, np.ndarray)):
        return value
    count = len(value)
    if item is None:
        raise DeviceRejectedError(
            f"the property {name} gives {count} values", hint="say which one by `item`, from 1"
        )
    if item > count:
        raise DeviceRejectedError(f"the property {name} gives {count} values, there is no {item}")
    one: object = value[item - 1]
    return one
