"""What is known of the rig, after each step that found something."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.member import Member
from rigrunner.panel.view.sections import Reading

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.events import Scanned, StepEnded, StepStarted
    from rigrunner.panel.view.sections import Readings

ICE_K = 273.15


def readings_after(known: Readings, event: StepEnded) -> Readings:
    """Return the readings with what a step set, read or measured."""
    return _with(known, event.values, event.units, is_set=event.action in ("set", "ramp"))


def readings_at(known: Readings, event: Scanned, scan: StepStarted) -> Readings:
    """Return the readings at a point of a scan: where its drive was set, and what was read."""
    own = {each: value for each, value in event.setpoints.items() if each not in scan.setpoints}
    return _with(_with(known, own, scan.units, is_set=True), event.values, scan.units)


def _with(
    known: Readings, values: Mapping[str, float], units: Mapping[str, str], *, is_set: bool = False
) -> Readings:
    found = {name: Reading(value=value, unit=units.get(name, "")) for name, value in values.items()}
    update: dict[str, object] = {"values": {**known.values, **found}}
    for name, value in values.items():
        match Member.parse(name).name, is_set:
            case "frequency", True:
                update |= {"set_frequency_hz": value, "frequency_hz": None}
            case "load", True:
                update["set_load_n"] = value
            case "load", False:
                update["load_n"] = value
            case "temperature", False:
                update["temperature_c"] = value - ICE_K
    return known.model_copy(update=update)
