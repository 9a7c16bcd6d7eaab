"""A device as a station binds it: its settings, the limits of its drives, its folder."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceError, UsageError, did_you_mean
from rigrunner.registry import load_registry
from rigrunner.run.lab_plugins import with_lab_plugins
from rigrunner.run.rig_lock import station_lock
from rigrunner.station import load_station
from rigrunner.station.drive_rules import DriveRules
from rigrunner_testing.device import DeviceSubject

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@contextmanager
def bound_subject(station: Path, role: str, plugin: str) -> Iterator[DeviceSubject]:
    """Yield the device of a role, ready for its checks within the station's limits.

    The rig is held meanwhile, and marked as energised while the device is in use. Raises UsageError
    for an unknown role, or one with another plugin, and DeviceError if a run has the rig, or it was
    left energised.
    """
    loaded = load_station(station)
    devices = loaded.model.devices
    if role not in devices:
        hint = did_you_mean(role, devices, f"there are: {', '.join(devices)}")
        raise UsageError(f"{station} has no device in the role '{role}'", hint=hint)
    bound = devices[role]
    if bound.plugin != plugin:
        raise UsageError(f"{station} has the plugin '{bound.plugin}' in the role '{role}'")
    registry = with_lab_plugins(load_registry(), loaded, station.parent)
    safety = loaded.model.safety
    rules = DriveRules(dict(safety.drives), safety.combinations)
    device_plugin = registry.find("device", plugin)
    registry.validated("device", plugin, bound.settings)
    subject = DeviceSubject(
        device_plugin, registry, bound.settings, folder=station.parent, role=role, rules=rules
    )
    with station_lock(loaded, registry, f"check-plugin {plugin}") as marks:
        if marks is not None and marks.left is not None and marks.unconfirmed:
            raise DeviceError(
                marks.left.text, hint=f"'rigrunner devices {station}' makes it safe first"
            )
        yield replace(subject, marks=marks if marks and role in marks.roles else None)
