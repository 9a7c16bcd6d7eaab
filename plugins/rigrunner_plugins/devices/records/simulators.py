"""Replayed recordings and tables of values.

Nothing here loads numpy; each `_name` function is the factory of one record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DeviceRecord

if TYPE_CHECKING:
    from rigrunner.api import Device, DeviceContext
    from rigrunner_plugins.devices.replay.settings import ReplaySettings
    from rigrunner_plugins.devices.tabulated.settings import TabulatedSettings

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


def _replay(settings: ReplaySettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.replay.device import Replay  # noqa: PLC0415  (numpy)

    return Replay(settings, context)


def _tabulated(settings: TabulatedSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.tabulated.device import Tabulated  # noqa: PLC0415  (when needed)

    return Tabulated(settings, context)


SIMULATORS = (
    DeviceRecord(
        name="replay",
        help="Recordings from CSV or HDF5 files, chosen by set frequency and load",
        settings="rigrunner_plugins.devices.replay.settings:ReplaySettings",
        factory=_replay,
        simulated=True,
    ),
    DeviceRecord(
        name="tabulated",
        help="Single values from a table, chosen by set-points, such as published ones",
        settings="rigrunner_plugins.devices.tabulated.settings:TabulatedSettings",
        trial=TABLE,
        factory=_tabulated,
        simulated=True,
    ),
)
