"""Checks of what a device declares before it is connected."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, get_args

from rigrunner.api.devices import ChannelInfo, Device, DriveInfo, Observing
from rigrunner.api.member import NAME
from rigrunner.api.readings import ReadingKind
from rigrunner.api.units import QuantityError, is_coherent, si_symbol, unit
from rigrunner.registry.methods import method_problems

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

_LEAST = ("channels", "drives", "non_blocking", "connect", "make_safe", "close")


def declaration_problems(device: object) -> Iterator[str]:
    """Yield what makes a device unusable, or its numbers ambiguous.

    An unknown unit is not a problem of the device: a procedure cannot use that channel.
    """
    if not isinstance(device, Device):
        missing = [name for name in _LEAST if not hasattr(device, name)]
        what = f"which has no {', '.join(missing)}"
        if not missing:  # from Python 3.12 on
            what = "of which __getattr__ gives members that its class must define"
        yield f"its factory gave a {type(device).__name__}, {what}"
        return
    for what, infos, kind in (
        ("channel", device.channels, ChannelInfo),
        ("drive", device.drives, DriveInfo),
    ):
        expected = f"expected a sequence of {kind.__name__}"
        if not isinstance(infos, (tuple, list)):
            yield f"got {infos!r}, {expected}"
            return
        wrong = [info for info in infos if not isinstance(info, kind)]
        if wrong:
            yield f"got {wrong[0]!r}, {expected}"
            return
        yield from _of_names(what, infos)
    yield from _of_readings(device)
    for info in device.drives:
        yield from (f"drive '{info.name}': {text}" for text in _of_drive(info))
    yield from method_problems(device)


def _of_readings(device: Device) -> Iterator[str]:
    if not isinstance(device, Observing):
        return
    channel_names = {info.name for info in device.channels}
    for info in device.readings:
        if not re.fullmatch(NAME, info.name):
            yield f"reading {info.name!r}: a name has letters, digits and '_', a letter first"
        if info.name in channel_names:
            yield f"reading '{info.name}': a channel has this name"
        if info.kind not in get_args(ReadingKind):
            yield f"reading '{info.name}': its kind is {info.kind!r}, none of the three"
        if info.unit:
            yield from (f"reading '{info.name}': {text}" for text in _of_unit(info.unit))


def _of_names(what: str, infos: Sequence[ChannelInfo | DriveInfo]) -> Iterator[str]:
    names = [str(info.name) for info in infos]
    for info in infos:
        if not isinstance(info.name, str) or not re.fullmatch(NAME, info.name):
            yield f"{what} {info.name!r}: a name has letters, digits and '_', a letter first"
        yield from (f"{what} '{info.name}': {text}" for text in _of_unit(info.unit))
    twice = sorted({name for name in names if names.count(name) > 1})
    yield from (f"{what} '{name}': the name is given twice" for name in twice)


def _of_unit(symbol: str) -> Iterator[str]:
    try:
        parsed = unit(symbol)
    except (QuantityError, AttributeError):  # unknown, or no text at all
        return
    if not is_coherent(parsed):
        yield f"is in '{symbol}', expected the coherent SI unit, {si_symbol(parsed.dimension)}"


def _of_drive(info: DriveInfo) -> Iterator[str]:
    limits = f"its limits are {info.minimum} and {info.maximum}"
    if not _finite((info.minimum, info.maximum)) or not info.minimum < info.maximum:
        yield f"{limits}, expected two finite numbers, the lower one first"
        return
    if not _finite([info.safe_value]):
        yield f"its safe value is {info.safe_value}"
    elif not info.minimum <= info.safe_value <= info.maximum:
        yield f"its safe value is {info.safe_value:g}, and {limits}"
    if info.rate_per_s is not None and not (_finite([info.rate_per_s]) and info.rate_per_s > 0):
        yield f"its rate is {info.rate_per_s}, expected a number above 0, or None"
    if info.tolerance is not None and not (_finite([info.tolerance]) and info.tolerance >= 0):
        yield f"its tolerance is {info.tolerance}, expected a number of at least 0, or None"
    if not (_finite([info.settle_s]) and info.settle_s >= 0):
        yield f"it settles in {info.settle_s} s"
    if info.sets_cycle_frequency and info.unit != "Hz":
        yield f"it sets the cycle frequency, in {info.unit}"


def _finite(values: Iterable[object]) -> bool:
    return all(isinstance(value, (float, int)) and math.isfinite(value) for value in values)
