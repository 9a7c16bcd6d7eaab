"""The simulated testers that ship. Nothing here loads numpy.

Each `_name` function is the factory of one record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DeviceRecord, hookimpl

if TYPE_CHECKING:
    from rigrunner.api import Device, DeviceContext
    from rigrunner_bearings.devices.rotation_tester_sim.settings import RotationTesterSettings
    from rigrunner_bearings.devices.swing_tester_ode.settings import SwingTesterOdeSettings
    from rigrunner_bearings.devices.swing_tester_sim.settings import SwingTesterSimSettings

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
            factory=_swing_tester_sim,
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="swing_tester_ode",
            help="Swing tester simulated in the time domain, independent of the closed form",
            settings="rigrunner_bearings.devices.swing_tester_ode.settings:SwingTesterOdeSettings",
            factory=_swing_tester_ode,
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="rotation_tester_sim",
            help="Bench that turns a bearing slowly from rest, simulated: breakaway without load",
            settings="rigrunner_bearings.devices.rotation_tester_sim.settings:RotationTesterSettings",
            factory=_rotation_tester_sim,
            simulated=True,
            absent=UNPLUGGED,
        ),
    ]


def _swing_tester_sim(settings: SwingTesterSimSettings, context: DeviceContext) -> Device:
    from rigrunner_bearings.devices.swing_tester_sim.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _swing_tester_ode(settings: SwingTesterOdeSettings, context: DeviceContext) -> Device:
    from rigrunner_bearings.devices.swing_tester_ode.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _rotation_tester_sim(settings: RotationTesterSettings, context: DeviceContext) -> Device:
    from rigrunner_bearings.devices.rotation_tester_sim.device import (  # noqa: PLC0415  (numpy)
        RotationTester,
    )

    return RotationTester(settings, context)
