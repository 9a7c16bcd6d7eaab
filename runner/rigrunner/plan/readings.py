"""The steps that find something: zero, record, measure, scan."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.plan.actions import Measure, Record, Recorded, Scan, Zero
from rigrunner.plan.terms import (
    judged_terms,
    planned_limits,
    recorded_limits,
    tried_terms,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.member import Member
    from rigrunner.api.quantity import Quantity
    from rigrunner.plan.draft import Place, Scene
    from rigrunner.procedure import doings

_LEAST_DIGITS = 3


def plan_zero(zero: doings.Zero, place: Place, scene: Scene) -> None:
    """Write down that a channel is read at rest."""
    at, within = (*place.path, "channel"), (*place.path, "within")
    role, name = zero.channel.role, zero.channel.name
    channel = scene.bench.channel(zero.channel, at)
    if channel is None or scene.bench.sample_rate_hz(role, at) is None:
        return
    if not scene.bench.can_record(zero.channel, at):
        return
    if not scene.bench.fits(zero.within, channel.unit, zero.channel, within):
        return
    if zero.within.si <= 0:
        scene.complain(within, f"got '{zero.within}', allowed is more than 0")
    scene.drives.require_rest(role, place.path)
    action = Zero(role, name, channel.unit, zero.within.si, zero.duration)
    limits = planned_limits(zero.limits, place, [zero.channel], scene)
    terms = judged_terms(zero, place, zero.duration, limits, scene)
    text = f"Zero {zero.channel}, within {zero.within}"
    scene.emit(place, action, text, zero.duration, terms)


def plan_measure(measure: doings.Measure, place: Place, scene: Scene) -> None:
    """Write down that single values are read, or averaged."""
    units = _units(measure.channels, place, scene)
    if not units:
        return
    seconds = measure.duration or 0.0
    rate_hz = _averaging_rate_hz(measure, place, scene) if seconds else None
    if rate_hz is None:
        for role in {member.role for member in units}:
            scene.bench.must_be_readable(role, place.path)
    action = Measure(
        name=measure.name,
        channels=measure.channels,
        duration_s=seconds,
        setpoints=scene.drives.values(),
        units=scene.drives.units() | units,
        sample_rate_hz=rate_hz,
    )
    how = f"mean over {seconds:.3g} s" if seconds else "once"
    limits = planned_limits(measure.limits, place, measure.channels, scene)
    terms = judged_terms(measure, place, seconds, limits, scene)
    text = f"Measure {', '.join(measure.channels)}, {how}"
    scene.emit(place, action, text, seconds, terms)


def plan_scan(scan: doings.Scan, place: Place, scene: Scene) -> None:
    """Write down that a drive goes through set-points, and what is read at each."""
    known = scene.drives.values()
    units, moved_s = _units(scan.channels, place, scene), _through(scan, place, scene)
    for role in {member.role for member in units}:
        scene.bench.must_be_readable(role, place.path)
    limits = tuple(planned_limits(scan.limits, place, scan.channels, scene)) if units else ()
    if not units or moved_s is None:
        return
    seconds = moved_s + len(scan.over) * (scan.settle or 0.0)
    action = Scan(
        name=scan.name,
        role=scan.set.role,
        drive=scan.set.name,
        values=tuple(each.si for each in scan.over),
        channels=scan.channels,
        settle_s=scan.settle or 0.0,
        setpoints={member: value for member, value in known.items() if member != scan.set},
        units=scene.drives.units() | units,
        limits=limits,
        stops_at_limit=scan.on_fail == "stop",
    )
    least, most, count = (*_ends(scan.over), len(scan.over))
    span = f"between {least} and {most}, {count} points" if count > 1 else f"at {least}, 1 point"
    text = f"Scan {scan.set} {span}, reading {', '.join(scan.channels)}"
    scene.emit(place, action, text, seconds, tried_terms(scan, place, seconds, scene))


def _ends(over: Sequence[Quantity]) -> tuple[Quantity, Quantity]:
    return min(over, key=lambda each: each.si), max(over, key=lambda each: each.si)


def _through(scan: doings.Scan, place: Place, scene: Scene) -> float | None:
    """Return how long the drive is on its way; None where a set-point is none of its."""
    seconds: list[float] = []
    for index, quantity in enumerate(scan.over):
        named_at, valued_at = (*place.path, "set"), (*place.path, "over", index)
        drive = scene.drives.resolve(scan.set, quantity, named_at, valued_at, key=False)
        if drive is not None:
            seconds.append(scene.drives.move(scan.set, drive, quantity.si))
    return sum(seconds) if len(seconds) == len(scan.over) else None


def plan_record(record: doings.Record, place: Place, scene: Scene) -> None:
    """Write down that channels of one device are recorded."""
    role, units = _one_role(record, place, scene)
    if not units:
        return
    duration_s, span = _span(record, role, place, scene)
    frequency_hz = scene.drives.known_cycle_frequency_hz(role)
    names = tuple(member.name for member in record.channels)
    conditions = scene.bench.conditions(role, names)
    limits = tuple(recorded_limits(record, place, conditions, scene))
    draft = scene.draft
    digits = max(_LEAST_DIGITS, len(str(draft.wanted)))
    number = f"{len(draft.recordings) + 1:0{digits}d}"
    action = Record(
        name=number if frequency_hz is None else f"{number}_{frequency_hz:.6g}Hz",
        role=role,
        channels=names,
        duration_s=duration_s,
        setpoints=scene.drives.values(),
        units=scene.drives.units() | units,
        cycle_frequency_hz=frequency_hz,
        sample_rate_hz=scene.bench.sample_rate_hz(role, place.path),
        statistics=tuple(each.of for each in limits if each.of not in conditions),
    )
    draft.recordings.append(Recorded(action, scene.document, place.path, conditions))
    terms = judged_terms(record, place, duration_s, limits, scene)
    text = f"Record {', '.join(action.channels)} of {role}, {span} ({duration_s:.3g} s)"
    scene.emit(place, action, text, duration_s, terms)


def _averaging_rate_hz(measure: doings.Measure, place: Place, scene: Scene) -> float | None:
    """Return the rate of the stream that is averaged; None where there is none."""
    first, *others = sorted({member.role for member in measure.channels})
    if others:
        message = f"channels of two devices in one average: {first}, {', '.join(others)}"
        hint = "a measure step for each device, or no duration"
        scene.complain((*place.path, "channels"), message, hint)
    if not all(scene.bench.streams(member) for member in measure.channels):
        return None
    return scene.bench.sample_rate_hz(first, place.path)


def _one_role(record: doings.Record, place: Place, scene: Scene) -> tuple[str, dict[Member, str]]:
    """Return the role and each channel's unit; no units where there is a problem with them."""
    units = _units(record.channels, place, scene)
    roles = sorted({member.role for member in record.channels})
    if len(roles) > 1:
        message = f"channels of two devices in one recording: {', '.join(roles)}"
        hint = "one clock, one device, one record"
        scene.complain((*place.path, "channels"), message, hint)
        return roles[0], {}
    path = (*place.path, "channels")
    able = [
        scene.bench.can_record(member, (*path, index))
        for index, member in enumerate(record.channels)
        if member in units
    ]
    return roles[0], units if all(able) else {}


def _units(channels: Sequence[Member], place: Place, scene: Scene) -> dict[Member, str]:
    """Return each channel's unit; none at all where there is a problem with one."""
    path = (*place.path, "channels")
    found = {
        member: scene.bench.channel(member, (*path, index)) for index, member in enumerate(channels)
    }
    if len(found) < len(channels):
        scene.complain(path, "a channel stands twice", "name it once")
        return {}
    units = {member: info.unit for member, info in found.items() if info}
    return units if len(units) == len(found) else {}


def _span(record: doings.Record, role: str, place: Place, scene: Scene) -> tuple[float, str]:
    """Return how long to record: a cycle more than asked for, so that as many are whole.

    Zero, which no plan is made of, where a problem keeps it from being known.
    """
    if record.duration is not None:
        return record.duration, "for a time"
    frequency_hz = scene.drives.cycle_frequency_hz(role, (*place.path, "cycles"))
    if not frequency_hz or record.cycles is None:
        return 0.0, ""
    duration_s = (record.cycles + 1) / frequency_hz
    return duration_s, f"{record.cycles} cycles at {frequency_hz:.6g} Hz"
