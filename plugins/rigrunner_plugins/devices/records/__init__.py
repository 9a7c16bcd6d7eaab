"""The devices that ship with Rigrunner. Nothing here loads numpy; factories import their device."""

from __future__ import annotations

from rigrunner.api import DeviceRecord, hookimpl
from rigrunner_plugins.devices.records.instruments import INSTRUMENTS
from rigrunner_plugins.devices.records.made_of_others import MADE_OF_OTHERS
from rigrunner_plugins.devices.records.simulators import SIMULATORS
from rigrunner_plugins.devices.records.text import TEXT_DEVICES


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Return simulated rigs, replayed recordings, tables of values, and faults for any device."""
    return [*SIMULATORS, *MADE_OF_OTHERS, *INSTRUMENTS, *TEXT_DEVICES]
