"""PyMeasure's classes: which there are, what properties they have, and whether one can be used."""

from __future__ import annotations

import difflib
import importlib
import inspect
import re
from typing import TYPE_CHECKING, Any, cast

from rigrunner.api import PluginError
from rigrunner_plugins.devices.extras import missing_package

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from rigrunner_plugins.devices.declared import DeclaredQuantity
    from rigrunner_plugins.devices.pymeasure.settings import PyMeasureSettings


def instrument_class(name: str) -> type[Any]:
    """Return the class of that dotted name; raise PluginError, or MissingPackageError.

    It is one of PyMeasure's own instruments, or it is refused: the settings see to its package,
    and what is found there has to derive from PyMeasure's Instrument.
    """
    try:
        from pymeasure.instruments import Instrument  # noqa: PLC0415  (a second, and optional)
    except ImportError as error:
        raise missing_package("pymeasure", "pymeasure") from error
    module_name, _, class_name = name.rpartition(".")
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise PluginError(
            f"PyMeasure's {module_name} cannot be loaded: {error}",
            hint="its documentation lists the instruments by maker",
        ) from error
    class_ = getattr(module, class_name, None)
    if not _is_subclass(class_, Instrument):
        names = [key for key, value in vars(module).items() if _is_subclass(value, Instrument)]
        raise PluginError(
            f"{module_name} has no instrument '{class_name}'", hint=_hint(class_name, names)
        )
    return cast("type[Any]", class_)


def properties_of(owner: type[Any]) -> list[str]:
    """Return the names of the properties that an instrument or channel class has of its own."""
    return [
        name
        for name in dir(owner)
        if not name.startswith("_") and isinstance(inspect.getattr_static(owner, name), property)
    ]


def check_names(class_: type[Any], settings: PyMeasureSettings) -> None:
    """Raise PluginError for a property or method that the class does not have, or a wrong unit.

    Those of its channels are known only once it is connected.
    """
    properties = properties_of(class_)
    for name in sorted(settings.properties):
        if "." not in name:
            need_property(class_, name, properties)
    channels = [(channel.property, channel) for channel in settings.channels.values()]
    drives = [(drive.property, drive) for drive in settings.drives.values()]
    for name, quantity in (*channels, *drives):
        if "." not in name:
            check_unit(class_, name, quantity)
    methods = [name for name in dir(class_) if is_callable_alone(class_, name)]
    for name in (*settings.calls, *settings.safe_calls):
        if name not in methods:
            raise PluginError(
                f"{class_.__name__} has no method '{name}' that needs no arguments",
                hint=_hint(name, methods),
            )


def need_property(owner: type[Any], name: str, properties: Collection[str] | None = None) -> None:
    """Raise PluginError unless the class has that property."""
    names = properties_of(owner) if properties is None else properties
    if name not in names:
        raise PluginError(f"{owner.__name__} has no property '{name}'", hint=_hint(name, names))


def is_callable_alone(owner: type[Any], name: str) -> bool:
    """Return whether a public method of a class can be called without arguments."""
    method = inspect.getattr_static(owner, name)
    if name.startswith("_") or not inspect.isfunction(method):
        return False
    _, *others = inspect.signature(method).parameters.values()
    return all(
        parameter.default is not parameter.empty
        or parameter.kind in {parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD}
        for parameter in others
    )


def _is_subclass(value: object, base: type[Any]) -> bool:
    """Return whether something is a class derived from a base."""
    return inspect.isclass(value) and issubclass(value, base) and value is not base


def _hint(name: str, candidates: Iterable[str]) -> str:
    names = sorted(candidates)
    near = difflib.get_close_matches(name, names, n=3)
    return f"did you mean {' or '.join(near)}?" if near else f"there are: {', '.join(names)}"


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


def unit_in_description(owner: type[Any], name: str) -> str:
    """Return the symbol of the one unit that a property's description names; empty if none.

    PyMeasure writes 'in Volts', 'in Hz', 'in seconds'.
    """
    text = inspect.getdoc(inspect.getattr_static(owner, name)) or ""
    units = {_symbol(word) for word in _IN_UNIT.findall(text)} - {""}
    return units.pop() if len(units) == 1 else ""


def check_unit(owner: type[Any], name: str, quantity: DeclaredQuantity) -> None:
    """Raise PluginError if the station has another unit and no scale."""
    symbol = unit_in_description(owner, name)
    if symbol and symbol != quantity.unit and "scale" not in quantity.model_fields_set:
        raise PluginError(
            f"the property {name} of {owner.__name__} is in {symbol}, as PyMeasure's description"
            f" says; the station has {quantity.unit} without a scale",
            hint=f"write 'unit: {symbol}', or `scale`, even if it is 1: how many {quantity.unit}"
            f" one {symbol} is",
        )


def _symbol(word: str) -> str:
    """Return the unit of a word; a single letter counts only as the symbol itself: 'in a'."""
    return _BY_WORD.get(word) or (_BY_WORD.get(word.lower(), "") if len(word) > 1 else "")
