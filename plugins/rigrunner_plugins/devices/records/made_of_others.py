"""Devices that are made of others.

Nothing here loads numpy; each `_name` function is the factory of one record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DeviceRecord
from rigrunner_plugins.devices.records.simulators import TABLE

if TYPE_CHECKING:
    from rigrunner.api import Device, DeviceContext
    from rigrunner_plugins.devices.composite.settings import CompositeSettings
    from rigrunner_plugins.devices.fault.settings import FaultyDeviceSettings

PARTS = {
    "parts": {
        "rig": {"plugin": "swing_tester_sim"},
        "table": {"plugin": "tabulated", "settings": TABLE},
    },
    "channels": {"angle": "rig.angle", "torque": "rig.torque", "reference": "table.torque"},
    "drives": {"frequency": "rig.frequency", "load": "rig.load"},
}
"""With which a role of several instruments is tried."""


def _fault(settings: FaultyDeviceSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.fault.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _composite(settings: CompositeSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.composite.device import make  # noqa: PLC0415  (when needed)

    return make(settings, context)


MADE_OF_OTHERS = (
    DeviceRecord(
        name="fault",
        help="Any other device with faults injected: lost, late, stuck, clipped, gaps, ...",
        settings="rigrunner_plugins.devices.fault.settings:FaultyDeviceSettings",
        trial={"plugin": "swing_tester_sim"},
        absent={"settings": {"simulate": "unplugged"}},
        factory=_fault,
        wired=True,
    ),
    DeviceRecord(
        name="composite",
        help="One role made of several instruments, each with its own plugin",
        settings="rigrunner_plugins.devices.composite.settings:CompositeSettings",
        trial=PARTS,
        factory=_composite,
        wired=True,  # by its parts: it exchanges nothing itself
    ),
)
