"""Finds in a recording what the analysis needs: channels by unit, set-points by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError, Member
from rigrunner.signal.blocks import limits
from rigrunner_bearings.api.points import MotionSource

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from rigrunner.api import Recording
    from rigrunner.api.data import Samples

INDEX = "index"
"""The name of a channel of pulses; all others are identified by their unit."""


def torque_channel(recording: Recording, registered: Collection[str] = ()) -> str:
    """Return the name of the torque channel; of several, the one in the instrument register."""
    channels = torque_channels(recording)
    chosen = [name for name in channels if name in registered] if len(channels) > 1 else channels
    if len(chosen) == 1:
        return chosen[0]
    if channels:
        raise DataError(
            f"recording {recording.name} has several torque channels: {', '.join(channels)}",
            hint="enter the one to analyse in the station's instruments",
        )
    others = sorted(f"{name} in {recording.units.get(name, '?')}" for name in recording.channels)
    raise DataError(
        f"recording {recording.name} has no torque channel; it has "
        f"{', '.join(others) or 'no channels'}",
        hint="record a channel in N·m, such as tester.torque",
    )


def torque_channels(recording: Recording) -> list[str]:
    """Return the names of all torque channels."""
    return _channels(recording, "N·m")


def motion_channel(recording: Recording) -> tuple[MotionSource, str]:
    """Return the best that shows the motion, with the channel's name; '' where nothing does.

    An angle, or else an angular velocity, or else a channel that is called 'index'.
    """
    for source, what, channels in (
        (MotionSource.ANGLE, "angle", _channels(recording, "rad")),
        (MotionSource.TACHO, "velocity", _channels(recording, "rad/s")),
        (
            MotionSource.INDEX,
            "index",
            [n for n in recording.channels if Member.parse(n).name == INDEX],
        ),
    ):
        if len(channels) > 1:
            raise DataError(
                f"recording {recording.name} has several {what} channels: {', '.join(channels)}",
                hint=f"record only the {what} of the swing",
            )
        if channels:
            return source, channels[0]
    return MotionSource.ENTERED, ""


def finite(recording: Recording, name: str) -> Samples:
    """Return the samples of a channel, shape (n,); raise DataError if one is not finite."""
    values = recording.channels[name]
    if len(values) and not np.isfinite(limits(values)).all():
        raise DataError(f"recording {recording.name}, {name}: a sample is not a finite number")
    return values


def set_frequency(recording: Recording, torque: str) -> float:
    """Return the set frequency, in Hz, of the device that owns the torque channel."""
    name = Member(role_of(torque), "frequency")
    return _value(recording, recording.setpoints, name, "set-point")


def is_set(recording: Recording, quantity: str) -> bool:
    """Return whether that quantity of a device that measured torque was set, and not to zero."""
    return any(
        recording.setpoints.get(Member(role_of(torque), quantity), 0.0) > 0
        for torque in torque_channels(recording)
    )


def place_of_start(setpoints: Mapping[str, float], role: str) -> tuple[float, float]:
    """Return the set speed of a start in Hz and the load in N; 0 where there is no drive."""
    speed_hz = setpoints.get(
        Member(role, "start_frequency"), setpoints.get(Member(role, "frequency"), 0.0)
    )
    return speed_hz, setpoints.get(Member(role, "load"), 0.0)


def load_n(recording: Recording, torque: str) -> float:
    """Return the load as it was read while recording, or else as it was set, in N."""
    name = Member(role_of(torque), "load")
    source = recording.conditions if name in recording.conditions else recording.setpoints
    return _value(recording, source, name, "load")


def _channels(recording: Recording, unit: str) -> list[str]:
    return sorted(name for name in recording.channels if recording.units.get(name) == unit)


def role_of(channel: str) -> str:
    """Return the role of the device that has a channel."""
    return Member.parse(channel).role


def _value(recording: Recording, source: Mapping[str, float], name: str, what: str) -> float:
    if name not in source:
        raise DataError(
            f"recording {recording.name} has no {what} '{name}'; "
            f"it has {', '.join(sorted(source)) or 'none'}"
        )
    return source[name]
