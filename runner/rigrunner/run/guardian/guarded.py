"""Which devices of a station a guardian covers, as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection

    from rigrunner.registry import Registry
    from rigrunner.station import LoadedStation

WITHOUT = "there is no guardian, as the station says (safety: guardian: no)"


def guardian_text(station: LoadedStation, registry: Registry, real: Collection[str]) -> str:
    """Return what guards the real devices of a station, as text; '' if there are none."""
    if not real:
        return ""
    if not station.model.safety.guardian:
        return WITHOUT
    if unreachable := not_reopenable(station, registry, real):
        names = ", ".join(unreachable)
        return (
            f"a guardian makes the rig safe if the process of a run dies or hangs, except {names}:"
            " no second process can open it, as its plugin says"
        )
    return "a guardian makes the rig safe if the process of a run dies or hangs"


def real_roles(station: LoadedStation, registry: Registry) -> list[str]:
    """Return the roles with real devices."""
    return [
        role
        for role, entry in station.model.devices.items()
        if not registry.is_simulated(entry.plugin, entry.settings)
    ]


def not_reopenable(station: LoadedStation, registry: Registry, roles: Collection[str]) -> list[str]:
    """Return the roles, among these, whose device cannot be opened by a second process."""
    devices = station.model.devices
    return sorted(
        role
        for role in roles
        if not registry.is_reopenable(devices[role].plugin, devices[role].settings)
    )
