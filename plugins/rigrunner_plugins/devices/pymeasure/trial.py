"""Settings with which the plugin can be tried without an instrument."""

from __future__ import annotations

from typing import Any

from rigrunner_plugins.devices.visa.trial import NOBODY

TRIAL: dict[str, Any] = {
    "instrument": "pymeasure.instruments.fakes.SwissArmyFake",
    "simulated": "yes",
    "resource": "ASRL1::INSTR",
    "channels": {"voltage": {"property": "voltage", "unit": "V"}},
    "drives": {
        "output": {
            "property": "output_voltage",
            "unit": "V",
            "min": "0 V",
            "max": "5 V",
            "safe": "0 V",
        }
    },
}
"""PyMeasure's own simulated instrument."""
ABSENT: dict[str, Any] = {
    "instrument": "pymeasure.instruments.keithley.Keithley2000",
    "resource": NOBODY,
    "simulated": "no",
    "drives": {},
}
