"""The closed-form rig as a device."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_plugins.devices.simulated.tester import SimulatedTester
from rigrunner_plugins.devices.swing_tester_sim.rig import closed_form_rig

if TYPE_CHECKING:
    from rigrunner.api.devices import Device, DeviceContext
    from rigrunner_plugins.devices.swing_tester_sim.settings import SwingTesterSimSettings


def make(settings: SwingTesterSimSettings, context: DeviceContext) -> Device:
    """Return the device; nothing is connected yet."""
    rig = closed_form_rig(settings.parameters())
    return SimulatedTester("swing_tester_sim", settings, rig, context)
