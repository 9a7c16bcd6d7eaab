"""Checks of the methods of a device: existence and signature."""

from __future__ import annotations

import difflib
import inspect
from typing import TYPE_CHECKING

from rigrunner.api.driver import Driver

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api.devices import Device

_DEVICE_METHODS = {
    "connect": ("timeout_s",),
    "make_safe": (),
    "close": (),
    "read": ("channels",),
    "set": ("drive", "value"),
    "read_back": ("drive",),
    "begin": ("drive", "value"),
    "arrived": ("drive",),
    "stream": ("channels", "duration_s", "stop"),
    "pause": (),
    "resume": (),
}
"""Arguments of each method, if a device has it."""
_DRIVER_METHODS = {
    "open": ("timeout_s",),
    "shut": (),
    "get": ("channel",),
    "get_all": ("channels",),
    "put": ("drive", "value"),
    "actual": ("drive",),
}


def place_of(function: object) -> str:
    """Return `file:line` of a Python function or class; '' for any other."""
    if isinstance(function, type):
        function = function.__init__  # type: ignore[misc]  # of this class
    code = getattr(inspect.unwrap(function), "__code__", None)  # type: ignore[arg-type]  # anything
    return f"{code.co_filename}:{code.co_firstlineno}" if code else ""


def call_problem(function: Callable[..., object], what: str, arguments: tuple[str, ...]) -> str:
    """Return why a function cannot be called with these arguments; '' if it can."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # a builtin without a signature
        return ""
    try:
        signature.bind(*arguments)
    except TypeError:
        expected = ", ".join(arguments) or "nothing"
        parameters = signature.replace(return_annotation=inspect.Signature.empty)
        return f"{what} takes {parameters}, and is called with {expected}{_at(function)}"
    return ""


def parameters(function: Callable[..., object]) -> tuple[str, ...]:
    """Return the names of the parameters of a function; empty if unknown."""
    try:
        return tuple(inspect.signature(function).parameters)
    except (TypeError, ValueError):
        return ()


def method_problems(device: Device) -> Iterator[str]:
    """Yield problems of the methods of a device, with their places."""
    kind = type(device)
    if isinstance(device, Driver):
        if not hasattr(device, "clock"):
            yield f"{kind.__name__}.__init__ does not call super().__init__(){_at(kind)}"
            return
        yield from _missing_methods(device)
    methods = _DEVICE_METHODS | (_DRIVER_METHODS if isinstance(device, Driver) else {})
    for name, arguments in methods.items():
        function = getattr(kind, name, None)
        if function is None or not inspect.isroutine(function):
            continue
        what = f"{kind.__name__}.{name}"
        if inspect.iscoroutinefunction(function) or inspect.isasyncgenfunction(function):
            yield (
                f"{what} is `async def`, and a device is called synchronously: write"
                f" `def {name}`{_at(function)}"
            )
            continue
        problem = call_problem(getattr(device, name), what, arguments)
        if problem:
            yield problem


def _missing_methods(device: Driver) -> Iterator[str]:
    kind = type(device)
    required: dict[str, tuple[str, ...]] = {"open": ("connect",)}
    if device.channels:
        required["get"] = ("get_all", "read")
    if device.drives:
        required["put"] = ("begin", "set")
    for name, others in required.items():
        if all(getattr(kind, method) is getattr(Driver, method) for method in (name, *others)):
            yield f"{kind.__name__} has no `{name}`{_near(kind, name)}"


def _near(kind: type[Driver], name: str) -> str:
    """Return a similar method of the class and its place; '' for none."""
    added = {method: getattr(kind, method) for method in dir(kind) if not hasattr(Driver, method)}
    methods = {method: value for method, value in added.items() if inspect.isfunction(value)}
    lower = {method.lower(): method for method in methods}
    matches = difflib.get_close_matches(name, lower, n=1)
    if not matches:
        return ""
    match = lower[matches[0]]
    return f": is `{match}` meant?{_at(methods[match])}"


def _at(function: object) -> str:
    place = place_of(function)
    return f" ({place})" if place else ""
