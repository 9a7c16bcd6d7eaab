"""What is known of the rig, after each event that says where something stands."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rigrunner_panel.view.sections import Reading

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.events import MadeSafe, Scanned, StepEnded, StepStarted

    Readings = Mapping[str, Reading]


class Units(NamedTuple):
    """The units of values, by name: SI, and in which people see them where that is known."""

    si: Mapping[str, str]
    shown_in: Mapping[str, str]


def readings_after(known: Readings, event: StepEnded, begun: StepStarted | None) -> Readings:
    """Return the readings with what a step read, measured, or read back of a drive."""
    told = begun.written_in if begun is not None else {}
    return _with(known, event.values, Units(event.units, told), event.utc)


def readings_at(known: Readings, event: Scanned, scan: StepStarted) -> Readings:
    """Return the readings at a point of a scan: where its drive was set, and what was read.

    What the drive stands at is not known until it is read: a scan does not tell its read-backs.
    """
    own = {each: value for each, value in event.setpoints.items() if each not in scan.setpoints}
    units = Units(scan.units, scan.written_in)
    at_set = readings_set(_with(known, own, units, event.utc), own)
    return _with(at_set, event.values, units, event.utc)


def readings_set(known: Readings, setpoints: Mapping[str, float]) -> Readings:
    """Return the readings with the set-points of drives, in SI units, where they are known."""
    return {
        name: each.with_set(setpoints[name]) if name in setpoints else each
        for name, each in known.items()
    }


def readings_safe(known: Readings, event: MadeSafe) -> Readings:
    """Return the readings with what was read back when a device was made safe."""
    after = _with(known, event.read_back, _units(known), event.utc)
    return {
        name: each.model_copy(update={"set": None}) if name in event.read_back else each
        for name, each in after.items()
    }


def readings_now(known: Readings, values: Mapping[str, float], utc: str) -> Readings:
    """Return the readings with what is read now of those that are known."""
    own = {name: value for name, value in values.items() if name in known}
    return _with(known, own, _units(known), utc)


def _units(known: Readings) -> Units:
    return Units(
        {name: each.unit for name, each in known.items()},
        {name: each.shown_in for name, each in known.items()},
    )


def _with(known: Readings, values: Mapping[str, float], units: Units, utc: str) -> Readings:
    found = {}
    for name, value in values.items():
        now = Reading.of(value, units.si.get(name, ""), units.shown_in.get(name, ""), utc)
        before = known.get(name)
        found[name] = now if before is None else now.model_copy(update={"set": before.set})
    return {**known, **found}
