"""Which part has each channel, reading and drive of the role."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner.api import PluginError, Readable, Settable, Streaming, unit
from rigrunner.api.devices import Observing
from rigrunner_plugins.devices.channels import info_of
from rigrunner_plugins.devices.composite.settings import DriveSource, split

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api import ChannelInfo, Device, DriveInfo
    from rigrunner.api.devices import ReadingInfo
    from rigrunner_plugins.devices.composite.settings import ClockSettings, CompositeSettings


@dataclass(frozen=True)
class ChannelRoute:
    """A channel of the role, with its part and its name there."""

    info: ChannelInfo
    part: str
    name: str


@dataclass(frozen=True)
class ReadingRoute:
    """A reading of the role that is not a number, with its part and its name there."""

    info: ReadingInfo
    part: str
    name: str


@dataclass(frozen=True)
class DriveRoute:
    """A drive of the role, with its part and its name there, and the channel that reads it back."""

    info: DriveInfo
    part: str
    name: str
    read_back: ChannelRoute | None = None


def channel_routes(
    settings: CompositeSettings, parts: Mapping[str, Device]
) -> dict[str, ChannelRoute]:
    """Return the routes of all channels; raise PluginError if a part does not have one."""
    return {
        name: _channel(f"channel {name}", name, place, parts)
        for name, place in settings.channels.items()
    }


def reading_routes(
    settings: CompositeSettings, parts: Mapping[str, Device]
) -> dict[str, ReadingRoute]:
    """Return the routes of all readings; raise PluginError if a part does not have one."""
    routes: dict[str, ReadingRoute] = {}
    for name, place in settings.readings.items():
        part, local_name = split(place)
        device = parts[part]
        infos = device.readings if isinstance(device, Observing) else ()
        info = info_of(infos, local_name, f"reading {name}: the part '{part}' has no reading")
        routes[name] = ReadingRoute(replace(info, name=name), part, local_name)
    return routes


def drive_routes(settings: CompositeSettings, parts: Mapping[str, Device]) -> dict[str, DriveRoute]:
    """Return the routes of all drives in the order of the station; raise PluginError."""
    return {
        name: _drive(f"drive {name}", name, source, parts)
        for name, source in settings.drives.items()
    }


def reference_of(
    clocks: ClockSettings, channels: Mapping[str, ChannelRoute], parts: Mapping[str, Device]
) -> str:
    """Return the part whose clock a recording uses; '' if nothing streams.

    Raises PluginError if this part does not stream, or is not the fastest one, since a faster one
    would be decimated without a filter; or if a part does not stream its common signal.
    """
    streaming = list(dict.fromkeys(route.part for route in channels.values() if route.info.streams))
    rates = {
        name: device.sample_rate_hz
        for name in streaming
        if isinstance(device := parts[name], Streaming)
    }
    reference = clocks.reference or next(iter(streaming), "")
    if not reference:
        return ""
    if reference not in rates:
        names = ", ".join(rates) or "none"
        raise PluginError(f"clocks: {reference} streams no channel", hint=f"those that do: {names}")
    fastest = max(rates, key=lambda name: rates[name])
    if rates[fastest] > rates[reference]:
        raise PluginError(
            f"clocks: {reference} has {rates[reference]:g} samples per second,"
            f" {fastest} {rates[fastest]:g}",
            hint=f"the reference must be the fastest: 'reference: {fastest}'",
        )
    for part, name in clocks.common.items():
        route = _channel("clocks: common", name, f"{part}.{name}", parts)
        if not route.info.streams:
            raise PluginError(f"clocks: common: {part}.{name} is not streamed")
    return reference


def _channel(what: str, name: str, place: str, parts: Mapping[str, Device]) -> ChannelRoute:
    part, local_name = split(place)
    device = parts[part]
    info = info_of(device.channels, local_name, f"{what}: the part '{part}' has no channel")
    if not isinstance(device, (Readable, Streaming)):
        raise PluginError(f"{what}: {part} gives neither single values nor recordings")
    streams = info.streams and isinstance(device, Streaming)
    return ChannelRoute(replace(info, name=name, streams=streams), part, local_name)


def _drive(
    what: str, name: str, source: str | DriveSource, parts: Mapping[str, Device]
) -> DriveRoute:
    place = source.set if isinstance(source, DriveSource) else source
    part, local_name = split(place)
    device = parts[part]
    info = replace(
        info_of(device.drives, local_name, f"{what}: the part '{part}' has no drive"), name=name
    )
    if not isinstance(device, Settable):
        raise PluginError(f"{what}: {part} cannot be set")
    if not isinstance(source, DriveSource):
        return DriveRoute(info, part, local_name)
    channel = _channel(what, local_name, source.read_back, parts)
    if channel.info.unit != info.unit:
        raise PluginError(
            f"{what}: it is set in {info.unit}, but {source.read_back} reads {channel.info.unit}"
        )
    tolerance = source.tolerance
    if tolerance is None:
        return DriveRoute(info, part, local_name, channel)
    if tolerance.dimension != unit(info.unit).dimension:
        raise PluginError(f"{what}: tolerance is '{tolerance}', it is set in {info.unit}")
    return DriveRoute(replace(info, tolerance=tolerance.si), part, local_name, channel)
