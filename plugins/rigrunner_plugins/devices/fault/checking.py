"""Whether the faults of a station fit the device that they are to befall."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import PluginError
from rigrunner.api.quantity import unit
from rigrunner_plugins.devices.fault.settings import CHANNELS_UNIT, NATURES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.devices import ChannelInfo, Device, DriveInfo
    from rigrunner_plugins.devices.fault.settings import FaultSettings


def check_faults(faults: Iterable[FaultSettings], device: Device) -> None:
    """Raise PluginError for a channel or drive that is not there, or a quantity of another kind."""
    for number, fault in enumerate(faults, start=1):
        where = f"fault {number} ({fault.kind})"
        _check_drives(where, fault, device)
        if fault.call == "stream":
            channel = _find(where, "channel", fault.channel, device.channels)
            if NATURES[fault.kind].dimension == CHANNELS_UNIT and fault.extent is not None:
                _check_unit(where, "extent", fault.extent.dimension, channel)


def _check_drives(where: str, fault: FaultSettings, device: Device) -> None:
    if fault.drive:
        _find(where, "drive", fault.drive, device.drives)
    for name, value in fault.at.items():
        _check_unit(where, "at", value.dimension, _find(where, "drive", name, device.drives))
    if fault.kind == "wrong frequency" and not any(d.sets_cycle_frequency for d in device.drives):
        raise PluginError(f"{where}: the device has no drive that sets a frequency")


def _find(
    where: str, what: str, name: str, infos: Iterable[ChannelInfo | DriveInfo]
) -> ChannelInfo | DriveInfo:
    by_name = {info.name: info for info in infos}
    if name not in by_name:
        raise PluginError(
            f"{where}: the device has no {what} '{name}'",
            hint=f"there are: {', '.join(by_name) or 'none'}",
        )
    return by_name[name]


def _check_unit(where: str, field: str, got: str, info: ChannelInfo | DriveInfo) -> None:
    wanted = unit(info.unit).dimension
    if got != wanted:
        raise PluginError(f"{where}: {field}: got a {got}, {info.name} takes a {wanted}")
