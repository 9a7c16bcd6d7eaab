"""Simulated rigs, replayed recordings and tables of values.

Nothing here loads numpy; each `_name` function is the factory of one record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import DeviceRecord

if TYPE_CHECKING:
    from rigrunner.api.devices import Device, DeviceContext
    from rigrunner_plugins.devices.replay.settings import ReplaySettings
    from rigrunner_plugins.devices.rotation_tester_sim.settings import RotationTesterSettings
    from rigrunner_plugins.devices.swing_tester_ode.settings import SwingTesterOdeSettings
    from rigrunner_plugins.devices.swing_tester_sim.settings import SwingTesterSimSettings
    from rigrunner_plugins.devices.tabulated.settings import TabulatedSettings

UNPLUGGED = {"simulate": "unplugged"}
"""With which a simulator is as if nobody was there."""
TABLE = {
    "title": "A table of three rows",
    "set_points": ["frequency", "load"],
    "cycle_frequency": "frequency",
    "rows": [
        {"frequency": "0 Hz", "load": "0 N", "angle": "0 deg", "torque": "0 N·m"},
        {"frequency": "1 Hz", "load": "10 N", "angle": "2 deg", "torque": "1.2 N·m"},
        {"frequency": "10 Hz", "load": "100 N", "angle": "2 deg", "torque": "1.3 N·m"},
    ],
}
"""With which the table is tried."""


def _swing_tester_sim(settings: SwingTesterSimSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.swing_tester_sim.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _swing_tester_ode(settings: SwingTesterOdeSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.swing_tester_ode.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _replay(settings: ReplaySettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.replay.device import Replay  # noqa: PLC0415  (numpy)

    return Replay(settings, context)


def _rotation_tester_sim(settings: RotationTesterSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.rotation_tester_sim.device import (  # noqa: PLC0415  (numpy)
        RotationTester,
    )

    return RotationTester(settings, context)


def _tabulated(settings: TabulatedSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.tabulated.device import Tabulated  # noqa: PLC0415  (when needed)

    return Tabulated(settings, context)


SIMULATORS = (
    DeviceRecord(
        name="swing_tester_sim",
        help="Swing tester simulated in closed form, with sensor errors and faults",
        settings="rigrunner_plugins.devices.swing_tester_sim.settings:SwingTesterSimSettings",
        factory=_swing_tester_sim,
        simulated=True,
        absent=UNPLUGGED,
    ),
    DeviceRecord(
        name="swing_tester_ode",
        help="Swing tester simulated in the time domain, independent of the closed form",
        settings="rigrunner_plugins.devices.swing_tester_ode.settings:SwingTesterOdeSettings",
        factory=_swing_tester_ode,
        simulated=True,
        absent=UNPLUGGED,
    ),
    DeviceRecord(
        name="replay",
        help="Recordings from CSV or HDF5 files, chosen by set frequency and load",
        settings="rigrunner_plugins.devices.replay.settings:ReplaySettings",
        factory=_replay,
        simulated=True,
    ),
    DeviceRecord(
        name="rotation_tester_sim",
        help="Bench that turns a bearing slowly from rest, simulated: breakaway without load",
        settings="rigrunner_plugins.devices.rotation_tester_sim.settings:RotationTesterSettings",
        factory=_rotation_tester_sim,
        simulated=True,
        absent=UNPLUGGED,
    ),
    DeviceRecord(
        name="tabulated",
        help="Single values from a table, chosen by set-points: a publication's, for one",
        settings="rigrunner_plugins.devices.tabulated.settings:TabulatedSettings",
        trial=TABLE,
        factory=_tabulated,
        simulated=True,
    ),
)
