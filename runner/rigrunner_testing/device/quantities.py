"""Checks on channels and drives: declared in SI units, and correct."""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api.devices import Approaching, Observing, Readable, Settable, Streaming
from rigrunner.api.errors import DeviceError
from rigrunner.api.member import NAME, Member
from rigrunner.api.units import find_unit, is_coherent, si_symbol
from rigrunner_testing.check import Nonconformity, NotApplicable, applies, check, demand
from rigrunner_testing.device.doing import (
    actual_if_off,
    defined_at,
    is_led,
    move,
    names,
    reader,
    refusal,
    set_point_at,
    setter,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api.devices import ChannelInfo, Device, DriveInfo
    from rigrunner_testing.device.subject import DeviceSubject

PARTS = (0.1, 0.25)
"""How far from its safe value a drive is set, once and then again, as fractions of its range."""
NO_SUCH = "no_such_name"
GRACE_S = 1.0
"""Time allowed beyond what the drives state: the exchanges take time as well."""


@check(
    fix="give ChannelInfo and DriveInfo the SI unit, and convert in `get` and `put`",
    needs=("connects_and_says_who_it_is",),
)
def quantities_declared(subject: DeviceSubject) -> None:
    """Channels and drives are declared before connecting: names, SI units, ranges, safe values."""
    device = subject.make()
    infos: list[ChannelInfo | DriveInfo] = [*device.channels, *device.drives]
    demand(infos, "it has neither channels nor drives")
    for group in (names(device.channels), names(device.drives)):
        demand(len(set(group)) == len(group), f"a name is given twice: {', '.join(group)}")
    for info in infos:
        demand(re.fullmatch(NAME, info.name), f"'{info.name}' is not a name for YAML")
        demand(info.long_name.strip(), f"{info.name} has no long name")
        objection = _unit_objection(info.unit)
        demand(not objection, f"{info.name} is in '{info.unit}'; {objection}")
    for info in device.drives:
        _check_range(info)
    demand(
        not device.drives or isinstance(device, Settable), "it has drives, but no set and read_back"
    )
    before = (list(device.channels), list(device.drives))
    with subject.connected() as connected:
        after = (list(connected.channels), list(connected.drives))
    demand(before == after, "once connected it has other channels or drives than before")


def _unit_objection(symbol: str) -> str:
    """Return which unit it should be instead; '' for a coherent SI unit."""
    unit = find_unit(symbol)
    if unit is None:
        return "that is not a known unit"
    if is_coherent(unit) and unit.symbol == symbol:
        return ""
    return f"expected the coherent SI unit, {si_symbol(unit.dimension)}"


def _check_range(info: DriveInfo) -> None:
    numbers = (info.minimum, info.maximum, info.safe_value)
    demand(all(map(math.isfinite, numbers)), f"{info.name} has limits {numbers}: not finite")
    demand(
        info.minimum < info.maximum, f"{info.name} reaches from {info.minimum:g} upwards to less"
    )
    inside = info.minimum <= info.safe_value <= info.maximum
    demand(inside, f"the safe value of {info.name}, {info.safe_value:g}, is beyond its limits")
    rate = info.rate_per_s
    demand(rate is None or 0 < rate < math.inf, f"the rate of {info.name} is {rate}")
    within = 0 < info.allowed_deviation <= info.maximum - info.minimum
    demand(within, f"the tolerance of {info.name} is {info.allowed_deviation:g} {info.unit}")
    demand(0 <= info.settle_s < math.inf, f"{info.name} settles in {info.settle_s} s")
    is_hertz = not info.sets_cycle_frequency or info.unit == "Hz"
    demand(is_hertz, f"{info.name} sets the cycle frequency, in {info.unit}")


@check(
    fix="return one finite float for each channel that is asked, in that order, in its SI unit",
    needs=("quantities_declared",),
)
def readings_are_true(subject: DeviceSubject) -> None:
    """A reading gives each requested channel one finite number, in the range of its drive."""
    with subject.connected() as device:
        channels = names(device.channels)[::-1]
        values = reader(device).read(channels)
        demand(
            isinstance(values, Mapping) and list(values) == channels,
            f"asked for {channels}, `read` returned {values!r}{defined_at(device, 'read')}",
        )
        for name, value in values.items():
            finite = isinstance(value, float) and math.isfinite(value)
            demand(
                finite,
                f"{name} reads {value!r}{defined_at(device, 'get')}, expected a finite float",
                fix=_float_remedy(value),
            )
        units = {info.name: info.unit for info in device.channels}
        for info in device.drives:
            if units.get(info.name) != info.unit:
                continue
            value, tolerance = values[info.name], info.allowed_deviation
            demand(
                info.minimum - tolerance <= value <= info.maximum + tolerance,
                f"{info.name} reads {value:g} {info.unit}, and its drive reaches from"
                f" {info.minimum:g} to {info.maximum:g} {info.unit}",
            )


@check(
    fix="let `observe` return a str, a bool or a tuple of finite numbers, as the kind says",
    needs=("quantities_declared",),
)
def readings_are_told(subject: DeviceSubject) -> None:
    """A reading that is not a number is of its declared kind: a text, a truth value, an array."""
    with subject.connected() as device:
        if not (isinstance(device, Observing) and device.readings):
            raise NotApplicable("all its readings are numbers")
        readings = [info.name for info in device.readings][::-1]
        shared = set(readings) & set(names(device.channels))
        demand(not shared, f"{', '.join(shared)} is a channel and a reading")
        values = device.observe(readings)
        demand(
            isinstance(values, Mapping) and list(values) == readings,
            f"asked for {readings}, `observe` returned {values!r}{defined_at(device, 'observe')}",
        )
        for info in device.readings:
            value = values[info.name]
            kind = {"text": str, "boolean": bool, "array": tuple}.get(info.kind)
            demand(kind, f"the kind of {info.name} is {info.kind!r}")
            demand(type(value) is kind, f"{info.name} is {value!r:.60}, and a {info.kind}")
            numbers = value if isinstance(value, tuple) else ()
            finite = all(isinstance(number, float) and math.isfinite(number) for number in numbers)
            demand(finite, f"{info.name} has numbers that are not finite floats")
        _check_unknown_name("telling a reading", partial(device.observe, [NO_SUCH]), readings)


def _float_remedy(value: object) -> str:
    """Return the remedy for a reading of another type; '' if that of the check applies."""
    if value is None:
        return "return the value: is there a `return`?"
    if isinstance(value, (str, bytes, int)):
        return f"convert the {type(value).__name__}: `return float(...)`"
    return ""


@check(
    moves=True,
    fix="return from `set` once the drive is there; state rate, settling, tolerance",
    needs=("readings_are_true",),
)
def drives_go_where_they_are_set(subject: DeviceSubject) -> None:
    """A drive reads back its set-point within its tolerance, in the time that it states."""
    clock = subject.clock()
    with subject.connected(clock=clock) as device:
        drives = setter(device)
        for part in PARTS:
            began_s = clock.monotonic_s()
            set_points = _move_all(subject, device, part)
            took_s = clock.monotonic_s() - began_s
            for info in device.drives:
                actual = actual_if_off(drives, info, set_points[info.name])
                setting = f"{info.name}, set to {set_points[info.name]:g} {info.unit}"
                demand(actual is None, f"{setting}, reads back {actual}")
            longest_s = sum(info.longest_s for info in subject.drives_of(device)) + GRACE_S
            demand(
                took_s <= longest_s,
                f"setting {len(set_points)} drives took {took_s:.1f} s, expected {longest_s:.1f} s",
            )


def _move_all(subject: DeviceSubject, device: Device, part: float) -> dict[str, float]:
    """Set every drive; if a set-point has no effect, `put` is the likely cause."""
    try:
        return move(subject, device, part)
    except DeviceError as error:
        raise Nonconformity(
            error.message,
            fix=f"send the set-point in `put`{defined_at(device, 'put')}, in the unit of the"
            " DriveInfo; state its rate, settling time and tolerance",
        ) from error


@check(
    moves=True,
    fix="let `begin` send the set-point and return, and `arrived` compare the read-back",
    needs=("drives_go_where_they_are_set",),
)
def drives_are_waited_for_by_asking(subject: DeviceSubject) -> None:
    """`begin` returns before the drive is there, and `arrived` reports when it is."""
    clock = subject.clock()
    with subject.connected(clock=clock) as device:
        setter(device)
        if not isinstance(device, Approaching):
            raise NotApplicable("its drives are there when `set` returns: it has no `begin`")
        drives = [info for info in device.drives if not is_led(subject, info)]
        applies(drives, "the station moves its drives in steps")
        for info in drives:
            value = set_point_at(subject.rules.narrowed(Member(subject.role, info.name), info))
            began_s = clock.monotonic_s()
            device.begin(info.name, value)
            waited_s = clock.monotonic_s() - began_s
            until_s = began_s + info.longest_s + GRACE_S
            demand(waited_s <= GRACE_S, f"beginning with {info.name} took {waited_s:.1f} s")
            while not device.arrived(info.name) and clock.monotonic_s() < until_s:
                clock.sleep(0.05)
            demand(
                device.arrived(info.name), f"{info.name} did not arrive at {value:g} {info.unit}"
            )
            actual = actual_if_off(device, info, value)
            demand(actual is None, f"{info.name} has arrived, and reads back {actual}")


@check(
    moves=True,
    fix="compare with DriveInfo before anything is sent: `if not low <= value <= high`",
    needs=("drives_go_where_they_are_set",),
)
def limits_hold(subject: DeviceSubject) -> None:
    """Set-points below, above or not a number are refused with the limits, and the drive stays."""
    with subject.connected() as device:
        drives = setter(device)
        set_points = move(subject, device)
        for info in device.drives:
            span = info.maximum - info.minimum
            beyond = (info.minimum - 0.01 * span, info.maximum + 0.01 * span)
            for invalid in (*beyond, math.nan, math.inf, -math.inf):
                what = f"setting {info.name} to {invalid:g} {info.unit}"
                message = str(refusal(what, partial(drives.set, info.name, invalid)))
                names_limits = f"{info.minimum:g}" in message and f"{info.maximum:g}" in message
                demand(names_limits, f"{what} is refused without its limits: {message}")
                if isinstance(device, Approaching):
                    begin = partial(device.begin, info.name, invalid)
                    refusal(f"beginning to do so: {what}", begin)
                before = set_points[info.name]
                actual = actual_if_off(drives, info, before)
                demand(
                    actual is None, f"{what} is refused, yet it moved from {before:g} to {actual}"
                )


@check(
    fix="raise DeviceRejectedError with the known names as its hint",
    needs=("readings_are_true",),
)
def unknown_names_refused(subject: DeviceSubject) -> None:
    """An unknown channel or drive is refused, and the existing ones are named."""
    with subject.connected() as device:
        channels, drives = names(device.channels), names(device.drives)
        if isinstance(device, Readable):
            _check_unknown_name("reading a channel", partial(device.read, [NO_SUCH]), channels)
        if isinstance(device, Streaming):
            stream = partial(device.stream, [NO_SUCH], 0.1, threading.Event())
            _check_unknown_name("streaming a channel", lambda: list(stream()), channels)
        if isinstance(device, Settable):
            _check_unknown_name("setting a drive", partial(device.set, NO_SUCH, 0.0), drives)
            _check_unknown_name("reading back a drive", partial(device.read_back, NO_SUCH), drives)


def _check_unknown_name(what: str, work: Callable[[], object], existing: list[str]) -> None:
    error = refusal(f"{what} '{NO_SUCH}'", work)
    missing = [name for name in existing if name not in str(error)]
    demand(not missing, f"'{error}' does not name {', '.join(missing)}")


CHECKS = (
    quantities_declared,
    readings_are_true,
    readings_are_told,
    drives_go_where_they_are_set,
    drives_are_waited_for_by_asking,
    limits_hold,
    unknown_names_refused,
)
