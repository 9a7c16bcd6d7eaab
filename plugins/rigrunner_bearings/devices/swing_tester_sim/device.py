"""The closed-form rig as a device."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner_bearings.devices.simulated.specimen import Specimen
from rigrunner_bearings.devices.simulated.tester import SimulatedTester
from rigrunner_bearings.devices.swing_tester_sim.rig import closed_form_rig

if TYPE_CHECKING:
    from rigrunner.api import Device, DeviceContext
    from rigrunner_bearings.devices.simulated.sampling import SimulatedRig
    from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
    from rigrunner_bearings.devices.swing_tester_sim.settings import SwingTesterSimSettings

WEAR_CYCLES = 10_000
"""The cycles by which the wear is stated."""


def make(settings: SwingTesterSimSettings, context: DeviceContext) -> Device:
    """Return the device; nothing is connected yet."""
    new = settings.parameters()
    return SimulatedTester(
        "swing_tester_sim", settings, closed_form_rig(new), context, _specimen(settings, new)
    )


def _specimen(settings: SwingTesterSimSettings, new: RigParameters) -> Specimen | None:
    """Return the bearing as it wears and warms; None for one that stays as it is."""
    bearing = settings.bearing
    if bearing.wear == 0 and bearing.warming == 0:
        return None

    def after(cycles: float) -> SimulatedRig:
        growth = max(1 + bearing.wear * cycles / WEAR_CYCLES, 0.0)
        worn = replace(
            new,
            starting_torque_nm=new.starting_torque_nm * growth,
            kinetic_torque_nm=new.kinetic_torque_nm * growth,
        )
        return closed_form_rig(worn)

    return Specimen(after, bearing.warming, bearing.warming_time)
