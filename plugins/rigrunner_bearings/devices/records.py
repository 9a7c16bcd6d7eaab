"""The simulated testers that ship. Nothing here loads numpy."""

from __future__ import annotations

from rigrunner.api import DeviceRecord, Imported, hookimpl

UNPLUGGED = {"simulate": "unplugged"}
"""With which a simulator is as if nobody was there."""


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Return the simulated testers."""
    return [
        DeviceRecord(
            name="swing_tester_sim",
            help="Swing tester simulated in closed form, with sensor errors and faults",
            settings="rigrunner_bearings.devices.swing_tester_sim.settings:SwingTesterSimSettings",
            factory=Imported("rigrunner_bearings.devices.swing_tester_sim.device:make"),
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="swing_tester_ode",
            help="Swing tester simulated in the time domain, independent of the closed form",
            settings="rigrunner_bearings.devices.swing_tester_ode.settings:SwingTesterOdeSettings",
            factory=Imported("rigrunner_bearings.devices.swing_tester_ode.device:make"),
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="rotation_tester_sim",
            help="Bench that turns a bearing slowly from rest, simulated: breakaway without load",
            settings="rigrunner_bearings.devices.rotation_tester_sim.settings:RotationTesterSettings",
            factory=Imported(
                "rigrunner_bearings.devices.rotation_tester_sim.device:RotationTester"
            ),
            simulated=True,
            absent=UNPLUGGED,
        ),
    ]
