"""Instruments as a station makes them, through the registry."""

from __future__ import annotations

from pathlib import Path

from rigrunner.api.devices import DeviceContext
from rigrunner.clock import WallClock
from rigrunner.registry import load_registry

REGISTRY = load_registry()


def instrument(plugin, settings, clock=None, folder=Path(), **context):
    """Return the device of a station with these settings."""
    device_context = DeviceContext("bench", clock or WallClock(), folder, **context)
    return REGISTRY.make_device(plugin, settings, device_context)


def merged(settings, **changes):
    """Return settings with some of them changed, or left out where the change is None."""
    merged_settings = {**settings, **changes}
    return {name: value for name, value in merged_settings.items() if value is not None}
