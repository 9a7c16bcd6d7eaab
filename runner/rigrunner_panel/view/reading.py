"""What is known of the rig, after each event that says where something stands."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rigrunner.api.member import Member
from rigrunner_panel.view.sections import Reading

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.events import MadeSafe, Scanned, StepEnded, StepStarted
    from rigrunner_panel.view.sections import Readings

ICE_K = 273.15


class Units(NamedTuple):
    """The units of values, by name: SI, and in which people see them where that is known."""

    si: Mapping[str, str]
    shown_in: Mapping[str, str]


def readings_after(known: Readings, event: StepEnded, begun: StepStarted | None) -> Readings:
    """Return the readings with what a step set, read or measured."""
    found = _set if event.action in ("set", "ramp") else _read
    told = begun.written_in if begun is not None else {}
    return found(known, event.values, Units(event.units, told), event.utc)


def readings_at(known: Readings, event: Scanned, scan: StepStarted) -> Readings:
    """Return the readings at a point of a scan: where its drive was set, and what was read.

    What the drive stands at is not known until it is read: a scan does not tell its read-backs.
    """
    own = {each: value for each, value in event.setpoints.items() if each not in scan.setpoints}
    update: dict[str, object] = {}
    for name, value in own.items():
        match Member.parse(name).name:
            case "frequency":
                update |= {"set_frequency_hz": value, "frequency_hz": None, "frequency_utc": ""}
            case "load":
                update |= {"set_load_n": value, "load_n": None, "load_utc": ""}
    units = Units(scan.units, scan.written_in)
    at_set = _with(known.model_copy(update=update), own, units, event.utc)
    return _read(at_set, event.values, units, event.utc)


def readings_safe(known: Readings, event: MadeSafe) -> Readings:
    """Return the readings with what was read back when a device was made safe."""
    units = {name: each.unit for name, each in known.values.items()}
    shown = {name: each.shown_in for name, each in known.values.items()}
    return _set(known, event.read_back, Units(units, shown), event.utc)


def _set(known: Readings, read_back: Mapping[str, float], units: Units, utc: str) -> Readings:
    update: dict[str, object] = {}
    for name, value in read_back.items():
        match Member.parse(name).name:
            case "frequency":
                update["set_frequency_hz"] = value
            case "load":
                update["set_load_n"] = value
    return _read(known.model_copy(update=update), read_back, units, utc)


def _read(known: Readings, values: Mapping[str, float], units: Units, utc: str) -> Readings:
    update: dict[str, object] = {}
    for name, value in values.items():
        match Member.parse(name).name:
            case "frequency":
                update |= {"frequency_hz": value, "frequency_utc": utc}
            case "load":
                update |= {"load_n": value, "load_utc": utc}
            case "temperature":
                update["temperature_c"] = value - ICE_K
    return _with(known.model_copy(update=update), values, units, utc)


def _with(known: Readings, values: Mapping[str, float], units: Units, utc: str) -> Readings:
    found = {
        name: Reading.of(value, units.si.get(name, ""), units.shown_in.get(name, ""), utc)
        for name, value in values.items()
    }
    return known.model_copy(update={"values": {**known.values, **found}})
