"""What is known of the rig, after each step that found something."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.panel.view.sections import Reading

if TYPE_CHECKING:
    from rigrunner.api.events import StepEnded
    from rigrunner.panel.view.sections import Readings

ICE_K = 273.15


def readings_after(known: Readings, event: StepEnded) -> Readings:
    """Return the readings with what a step set, read or measured."""
    found = {
        name: Reading(value=value, unit=event.units.get(name, ""))
        for name, value in event.values.items()
    }
    update: dict[str, object] = {"values": {**known.values, **found}}
    is_set = event.action in ("set", "ramp")
    for name, value in event.values.items():
        match name.rpartition(".")[2], is_set:
            case "frequency", True:
                update |= {"set_frequency_hz": value, "frequency_hz": None}
            case "load", True:
                update["set_load_n"] = value
            case "load", False:
                update["load_n"] = value
            case "temperature", False:
                update["temperature_c"] = value - ICE_K
    return known.model_copy(update=update)
