"""Finds in a recording what the analysis needs: channels by unit, set-points by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from rigrunner.api.data import Recording


def torque_channel(recording: Recording, registered: Collection[str] = ()) -> str:
    """Return the name of the torque channel; of several, the one in the instrument register."""
    found = _channels(recording, "N·m")
    chosen = [name for name in found if name in registered] if len(found) > 1 else found
    if len(chosen) == 1:
        return chosen[0]
    if found:
        raise DataError(
            f"recording {recording.name} has several torque channels: {', '.join(found)}",
            hint="enter the one to analyse in the station's instruments",
        )
    raise DataError(
        f"recording {recording.name} has no torque channel; it has {_listing(recording)}",
        hint="record a channel in N·m, such as tester.torque",
    )


def angle_channel(recording: Recording) -> str:
    """Return the name of the angle channel; raise DataError saying what it is needed for."""
    found = _channels(recording, "rad")
    if len(found) == 1:
        return found[0]
    if found:
        raise DataError(
            f"recording {recording.name} has several angle channels: {', '.join(found)}",
            hint="record only the angle of the swing",
        )
    raise DataError(
        f"recording {recording.name} has no angle channel; it has {_listing(recording)}",
        hint="every method here takes frequency and cycles from the angle; "
        "record a channel in rad or deg, such as tester.angle",
    )


def set_point(recording: Recording, torque: str, quantity: str) -> float:
    """Return the set value of a quantity of the device that owns the torque channel."""
    return _value(recording, recording.setpoints, f"{_role(torque)}.{quantity}", "set-point")


def load_n(recording: Recording, torque: str) -> float:
    """Return the load as it was read while recording, or else as it was set, in N."""
    name = f"{_role(torque)}.load"
    source = recording.conditions if name in recording.conditions else recording.setpoints
    return _value(recording, source, name, "load")


def _channels(recording: Recording, unit: str) -> list[str]:
    return sorted(name for name in recording.channels if recording.units.get(name) == unit)


def _role(channel: str) -> str:
    return channel.split(".", 1)[0]


def _value(recording: Recording, source: Mapping[str, float], name: str, what: str) -> float:
    if name not in source:
        raise DataError(
            f"recording {recording.name} has no {what} '{name}'; "
            f"it has {', '.join(sorted(source)) or 'none'}"
        )
    return source[name]


def _listing(recording: Recording) -> str:
    channels = (f"{name} in {recording.units.get(name, '?')}" for name in recording.channels)
    return ", ".join(sorted(channels)) or "no channels"
