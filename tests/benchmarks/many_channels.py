"""A slow instrument with 200 channels that are read one by one: a plugin of one file."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

from rigrunner.api import ChannelInfo, DeviceRecord, Driver, Identity, Settings, hookimpl

if TYPE_CHECKING:
    from rigrunner.api import DeviceContext

api_version = 1
CHANNELS = 200


class ManyChannels(Driver):
    """Each channel is another sine; every reading has all digits of a float."""

    channels = tuple(ChannelInfo(f"c{i:03d}", "N", f"Channel {i}") for i in range(CHANNELS))
    non_blocking = True

    def __init__(self, settings: Settings, context: DeviceContext) -> None:  # noqa: ARG002
        super().__init__(context)

    def open(self, timeout_s: float) -> Identity:  # noqa: ARG002
        return Identity("Rigrunner", "many channels", "SIM-MC-01", simulated=True)

    def get(self, channel: str) -> float:
        return math.sin(time.monotonic() + int(channel[1:]))


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    return [
        DeviceRecord(
            name="many_channels",
            help="200 channels (simulated)",
            settings=Settings,
            factory=ManyChannels,
            simulated=True,
        )
    ]
