"""Makes a composite of the abilities that its parts give it."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from rigrunner.api.devices import CountsStreams, KnowsTruth
from rigrunner_plugins.devices.composite.abilities import (
    CountsPartsStreams,
    KnowsPartsTruth,
    Observes,
    Pauses,
    Reads,
    Sets,
    Streams,
)
from rigrunner_plugins.devices.composite.base import Composite
from rigrunner_plugins.devices.composite.part import Part
from rigrunner_plugins.devices.composite.routes import (
    channel_routes,
    drive_routes,
    reading_routes,
    reference_of,
)

if TYPE_CHECKING:
    from rigrunner.api import Device, DeviceContext
    from rigrunner_plugins.devices.composite.settings import CompositeSettings


def make(settings: CompositeSettings, context: DeviceContext) -> Device:
    """Return the composite: it has the abilities that its parts give it.

    Raises PluginError where a part cannot be made, or lacks a channel or drive that is named.
    """
    devices = {
        name: context.make(part.plugin, part.settings, part=name)
        for name, part in settings.parts.items()
    }
    channels, drives = channel_routes(settings, devices), drive_routes(settings, devices)
    readings = reading_routes(settings, devices)
    reference = reference_of(settings.clocks, channels, devices)
    parts = {
        name: Part(name, context.role, device, context.patience) for name, device in devices.items()
    }
    abilities: list[type[Composite]] = []
    abilities += [Reads] if channels else []
    abilities += [Observes] if readings else []
    abilities += [Streams] if any(route.info.streams for route in channels.values()) else []
    swings = any(route.info.sets_cycle_frequency for route in drives.values())
    abilities += [Pauses if swings else Sets] if drives else []
    abilities += [
        ability
        for type_, ability in ((CountsStreams, CountsPartsStreams), (KnowsTruth, KnowsPartsTruth))
        if any(isinstance(device, type_) for device in devices.values())
    ]
    kind = type("CompositeDevice", (*abilities, Composite), {})
    return cast(
        "Device", kind(context, parts, channels, drives, readings, settings.clocks, reference)
    )
