"""The unit that PyMeasure's description of a property names, where it names one."""

from __future__ import annotations

import inspect
import re
from typing import TYPE_CHECKING, Any

from rigrunner.api import PluginError

if TYPE_CHECKING:
    from rigrunner_plugins.devices.declared import DeclaredQuantity

_SPELLINGS = {
    "V": ("V", "volt", "volts"),
    "mV": ("mV", "millivolt", "millivolts"),
    "A": ("A", "amp", "amps", "ampere", "amperes"),
    "mA": ("mA", "mAmps", "milliamp", "milliamps"),
    "Hz": ("Hz", "hz", "hertz"),
    "kHz": ("kHz", "khz", "kilohertz"),
    "s": ("s", "second", "seconds"),
    "ms": ("ms", "millisecond", "milliseconds"),
    "min": ("minute", "minutes"),
    "K": ("K", "kelvin"),
    "°C": ("°C", "degC", "celsius", "centigrade"),
    "deg": ("degree", "degrees"),
    "%": ("%", "percent"),
    "rpm": ("rpm",),
}
_BY_WORD = {word: symbol for symbol, words in _SPELLINGS.items() for word in words}
_IN_UNIT = re.compile(
    r"\bin\s+(?:units\s+of\s+)?(?:degrees?\s+(?=[cCkK]))?([A-Za-z°%]+)", re.IGNORECASE
)


def unit_told(owner: type[Any], name: str) -> str:
    """Return the symbol of the one unit that a property's description names; empty if none.

    PyMeasure writes 'in Volts', 'in Hz', 'in seconds'.
    """
    text = inspect.getdoc(inspect.getattr_static(owner, name)) or ""
    named = {_symbol(word) for word in _IN_UNIT.findall(text)} - {""}
    return named.pop() if len(named) == 1 else ""


def check_unit(owner: type[Any], name: str, quantity: DeclaredQuantity) -> None:
    """Raise PluginError where the station has another unit and says not how to come to it."""
    told = unit_told(owner, name)
    if told and told != quantity.unit and "scale" not in quantity.model_fields_set:
        raise PluginError(
            f"the property {name} of {owner.__name__} is in {told}, as PyMeasure's description"
            f" says; the station has {quantity.unit} without a scale",
            hint=f"write 'unit: {told}', or `scale`, even if it is 1: how many {quantity.unit}"
            f" one {told} is",
        )


def _symbol(word: str) -> str:
    """Return the unit of a word; a single letter counts only as the symbol itself: 'in a'."""
    return _BY_WORD.get(word) or (_BY_WORD.get(word.lower(), "") if len(word) > 1 else "")
