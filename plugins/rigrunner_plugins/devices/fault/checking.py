"""Whether the faults of a station fit their device."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import PluginError, unit
from rigrunner.api.units import with_article
from rigrunner_plugins.devices.channels import named
from rigrunner_plugins.devices.fault.settings import CHANNELS_UNIT, NATURES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api import ChannelInfo, Device, DriveInfo
    from rigrunner_plugins.devices.fault.settings import FaultSettings


def check_faults(faults: Iterable[FaultSettings], device: Device) -> None:
    """Raise PluginError for a channel or drive that is not there, or a quantity of another kind."""
    for number, fault in enumerate(faults, start=1):
        where = f"fault {number} ({fault.kind})"
        _check_drives(where, fault, device)
        if fault.call == "stream":
            channel = named(device.channels, fault.channel, f"{where}: the device has no channel")
            if NATURES[fault.kind].dimension == CHANNELS_UNIT and fault.extent is not None:
                _check_unit(where, "extent", fault.extent.dimension, channel)


def _check_drives(where: str, fault: FaultSettings, device: Device) -> None:
    no_drive = f"{where}: the device has no drive"
    if fault.drive:
        named(device.drives, fault.drive, no_drive)
    for name, value in fault.at.items():
        _check_unit(where, "at", value.dimension, named(device.drives, name, no_drive))
    if fault.kind == "wrong frequency" and not any(d.sets_cycle_frequency for d in device.drives):
        raise PluginError(f"{where}: the device has no drive that sets a frequency")


def _check_unit(where: str, field: str, got: str, info: ChannelInfo | DriveInfo) -> None:
    wanted = unit(info.unit).dimension
    if got != wanted:
        raise PluginError(
            f"{where}: {field}: got {with_article(got)}, {info.name} takes {with_article(wanted)}"
        )
