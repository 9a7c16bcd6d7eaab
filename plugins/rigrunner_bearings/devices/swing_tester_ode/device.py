"""The time-domain rig as a device."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_bearings.devices.simulated.tester import SimulatedTester
from rigrunner_bearings.devices.swing_tester_ode.rig import time_domain_rig

if TYPE_CHECKING:
    from rigrunner.api import Device, DeviceContext
    from rigrunner_bearings.devices.swing_tester_ode.settings import SwingTesterOdeSettings


def make(settings: SwingTesterOdeSettings, context: DeviceContext) -> Device:
    """Return the device; nothing is connected yet."""
    rig = time_domain_rig(settings.parameters())
    return SimulatedTester("swing_tester_ode", settings, rig, context)
