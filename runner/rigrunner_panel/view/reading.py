"""The latest readings of the rig, updated by events."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rigrunner_panel.view.sections import Reading

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.events import MadeSafe, Scanned, StepEnded, StepStarted

    Readings = Mapping[str, Reading]


class Units(NamedTuple):
    """The units of values, by name: in SI, and as shown if that is known."""

    si: Mapping[str, str]
    shown_in: Mapping[str, str]


def readings_after(readings: Readings, event: StepEnded, begun: StepStarted | None) -> Readings:
    """Return the readings with what a step read, measured, or read back of a drive."""
    written_in = begun.written_in if begun is not None else {}
    return _with(readings, event.values, Units(event.units, written_in), event.utc)


def readings_at(readings: Readings, event: Scanned, scan: StepStarted) -> Readings:
    """Return the readings at a point of a scan: where its drive was set, and what was read.

    The read-back of the drive is not known: a scan does not report it.
    """
    others = {name: value for name, value in event.setpoints.items() if name not in scan.setpoints}
    units = Units(scan.units, scan.written_in)
    at_set = readings_set(_with(readings, others, units, event.utc), others)
    return _with(at_set, event.values, units, event.utc)


def readings_set(readings: Readings, setpoints: Mapping[str, float]) -> Readings:
    """Return the readings with the set-points of drives, in SI units, where they are known."""
    return {
        name: reading.with_set(setpoints[name]) if name in setpoints else reading
        for name, reading in readings.items()
    }


def readings_safe(readings: Readings, event: MadeSafe) -> Readings:
    """Return the readings with what was read back when a device was made safe."""
    after = _with(readings, event.read_back, _units(readings), event.utc)
    return {
        name: reading.model_copy(update={"set": None}) if name in event.read_back else reading
        for name, reading in after.items()
    }


def readings_now(readings: Readings, values: Mapping[str, float], utc: str) -> Readings:
    """Return the readings with the new values of those that are already there."""
    shown = {name: value for name, value in values.items() if name in readings}
    return _with(readings, shown, _units(readings), utc)


def _units(readings: Readings) -> Units:
    return Units(
        {name: reading.unit for name, reading in readings.items()},
        {name: reading.shown_in for name, reading in readings.items()},
    )


def _with(readings: Readings, values: Mapping[str, float], units: Units, utc: str) -> Readings:
    changed = {}
    for name, value in values.items():
        now = Reading.of(value, units.si.get(name, ""), units.shown_in.get(name, ""), utc)
        before = readings.get(name)
        changed[name] = now if before is None else now.model_copy(update={"set": before.set})
    return {**readings, **changed}
