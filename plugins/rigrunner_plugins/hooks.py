"""What ships with Rigrunner as plugins. Nothing here loads numpy; factories import what they make.

Each `_name` function is the factory of one record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import DeviceRecord, hookimpl
from rigrunner_plugins.devices.swing_tester_sim.settings import SwingTesterSimSettings

if TYPE_CHECKING:
    from rigrunner.api.devices import Device, DeviceContext


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Return simulated swing testers and the replay of recordings."""
    return [
        DeviceRecord(
            name="swing_tester_sim",
            help="Swing tester simulated in closed form, with sensor errors and faults",
            settings=SwingTesterSimSettings,
            factory=_swing_tester_sim,
            simulated=True,
        ),
    ]


def _swing_tester_sim(settings: SwingTesterSimSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.swing_tester_sim.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)
