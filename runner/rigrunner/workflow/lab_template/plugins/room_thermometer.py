"""A thermometer for the room: an example of a device of your own, in one file.

It is simulated: the temperature swings by 1 K around a mean in the course of a day. Put your
instrument's talk into `connect` and `read`, and take out `simulated`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rigrunner.api.devices import ChannelInfo, DriveInfo, Identity
from rigrunner.api.hooks import DeviceRecord, hookimpl
from rigrunner.api.settings import Settings, Temperature

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.devices import DeviceContext

api_version = 1
DAY_S = 86400.0


class RoomThermometerSettings(Settings):
    """What the station may say of it."""

    mean: Temperature = 295.15
    """Around which the temperature swings."""


class RoomThermometer:
    """Values are in the SI unit of their kind: kelvin, newton, metre, second."""

    channels: Sequence[ChannelInfo] = (ChannelInfo("temperature", "K", "Room temperature"),)
    drives: Sequence[DriveInfo] = ()
    non_blocking = True

    def __init__(self, settings: RoomThermometerSettings, context: DeviceContext) -> None:
        self._mean_k = settings.mean
        self._clock = context.clock

    def connect(self, timeout_s: float) -> Identity:
        """Say who answers; raise DeviceNotFoundError where nobody does."""
        return Identity("Rigrunner", "room thermometer", "SIM-TH-01", simulated=True)

    def read(self, channels: Sequence[str]) -> dict[str, float]:
        """Return the temperature; raise DeviceTimeoutError or DeviceLostError."""
        phase = 2 * math.pi * (self._clock.utc().timestamp() % DAY_S) / DAY_S
        return dict.fromkeys(channels, self._mean_k - math.cos(phase))

    def make_safe(self) -> dict[str, float]:
        """Do nothing: a thermometer drives nothing."""
        return {}

    def close(self) -> None:
        """There is no connection to give back."""


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
