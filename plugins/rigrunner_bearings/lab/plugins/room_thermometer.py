"""A thermometer for the room: an example of a device of your own, in one file.

It is simulated: the temperature swings by 1 K around a mean in the course of a day. Put your
instrument's talk into `open` and `get`, and take out `simulated`. `rigrunner new device NAME
--drop-in` makes another such file, of an instrument that also has a drive.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rigrunner.api import (
    ChannelInfo,
    DeviceRecord,
    Driver,
    Identity,
    Settings,
    Temperature,
    hookimpl,
)

if TYPE_CHECKING:
    from rigrunner.api import DeviceContext

api_version = 1
DAY_S = 86400.0


class RoomThermometerSettings(Settings):
    """What the station may say of it."""

    mean: Temperature = 295.15
    """Around which the temperature swings."""


class RoomThermometer(Driver):
    """Values are in the SI unit of their kind: kelvin, newton, metre, second."""

    channels = (ChannelInfo("temperature", "K", "Room temperature", shown_in="°C"),)
    non_blocking = True

    def __init__(self, settings: RoomThermometerSettings, context: DeviceContext) -> None:
        super().__init__(context)
        self._mean_k = settings.mean

    def open(self, timeout_s: float) -> Identity:
        """Say who answers; raise DeviceNotFoundError where nobody does."""
        return Identity("Rigrunner", "room thermometer", "SIM-TH-01", simulated=True)

    def get(self, channel: str) -> float:
        """Return the temperature; raise DeviceTimeoutError or DeviceLostError."""
        phase = 2 * math.pi * (self.clock.utc().timestamp() % DAY_S) / DAY_S
        return self._mean_k - math.cos(phase)


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Tell Rigrunner what is in this file."""
    return [
        DeviceRecord(
            name="room_thermometer",
            help="Temperature of the room (simulated)",
            settings=RoomThermometerSettings,
            factory=RoomThermometer,
            simulated=True,
        )
    ]
