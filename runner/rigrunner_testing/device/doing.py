"""Shared by several checks: set and stream a device, and test what it refuses."""

from __future__ import annotations

import math
import threading
from typing import TYPE_CHECKING

from rigrunner.api.devices import Readable, Settable, Streaming
from rigrunner.api.errors import DeviceError, DeviceRejectedError
from rigrunner.api.member import Member
from rigrunner.registry import place_of
from rigrunner_testing.check import Nonconformity, NotApplicable

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api.data import Block
    from rigrunner.api.devices import ChannelInfo, Device, DriveInfo
    from rigrunner_testing.device.subject import DeviceSubject

CHANNELS_STREAMED = 8
"""Of a device with more channels, the first ones are streamed."""
PROBE_S = 0.02
"""How long is streamed to see which channels can be streamed together."""
LEAD_S = 0.2
"""Time between two steps of a drive that is moved slowly."""
SMALL_STEP = 0.1
"""The fraction of the range by which a drive is moved away from its safe value."""


def refusal(what: str, work: Callable[[], object]) -> DeviceError:
    """Return the DeviceError of the refused call; raise Nonconformity if it is not refused."""
    try:
        work()
    except DeviceError as error:
        return error
    except Exception as error:
        raise Nonconformity(
            f"{what} raises {type(error).__name__}, which is not a DeviceError: {error}"
        ) from error
    raise Nonconformity(f"{what} is not refused")


def safely(what: str, work: Callable[[], object]) -> bool:
    """Return whether the call succeeds; raise Nonconformity if it raises no DeviceError."""
    try:
        work()
    except DeviceError:
        return False
    except Exception as error:
        raise Nonconformity(
            f"{what} raises {type(error).__name__}, which is not a DeviceError: {error}"
        ) from error
    return True


def defined_at(device: Device, method: str) -> str:
    """Return where a device's own class defines a method, as ' (file:line)'; '' if it does not."""
    function = type(device).__dict__.get(method)
    return f" ({place_of(function)})" if function is not None else ""


def reader(device: Device) -> Readable:
    """Return the device if it can be read; raise NotApplicable."""
    if not (isinstance(device, Readable) and device.channels):
        raise NotApplicable("it gives no single values")
    return device


def setter(device: Device) -> Settable:
    """Return the device if it has drives; raise NotApplicable."""
    if not (isinstance(device, Settable) and device.drives):
        raise NotApplicable("it has no drives")
    return device


def streamer(device: Device) -> Streaming:
    """Return the device if it streams; raise NotApplicable."""
    if not isinstance(device, Streaming):
        raise NotApplicable("it does not stream")
    return device


def names(infos: Sequence[ChannelInfo] | Sequence[DriveInfo]) -> list[str]:
    """Return the names."""
    return [info.name for info in infos]


def streamed_names(device: Device) -> list[str]:
    """Return the channels that the checks stream: all, or those that can be streamed together."""
    streaming = [info.name for info in device.channels if info.streams][:CHANNELS_STREAMED]
    if _stream_together(device, streaming):
        return streaming
    together: list[str] = []
    for name in streaming:
        if _stream_together(device, [*together, name]):
            together.append(name)
    return together


def _stream_together(device: Device, channels: list[str]) -> bool:
    """Return whether these can be streamed at once; those of two clocks, for example, cannot."""
    stream = None
    try:
        stream = iter(streamer(device).stream(channels, PROBE_S, threading.Event()))
        next(stream, None)
    except DeviceRejectedError:
        return False
    finally:
        close_stream(stream)
    return True


def close_stream(stream: Iterator[Block] | None) -> None:
    """Leave a stream before its end."""
    close = getattr(stream, "close", None)
    if close is not None:
        close()


def set_point_at(info: DriveInfo, part: float = SMALL_STEP) -> float:
    """Return a set-point at that fraction of the range away from the safe value."""
    room_above = info.maximum - info.safe_value >= info.safe_value - info.minimum
    step = part * (info.maximum - info.minimum)
    return info.safe_value + step if room_above else info.safe_value - step


def move(subject: DeviceSubject, device: Device, part: float = SMALL_STEP) -> dict[str, float]:
    """Move every drive away from its safe value, within the station's limits.

    Returns the set-points.
    """
    if not isinstance(device, Settable):
        return {}
    set_points = {info.name: set_point_at(info, part) for info in subject.drives_of(device)}
    for info in device.drives:
        member, value = Member(subject.role, info.name), set_points[info.name]
        allowed = subject.rules.narrowed(member, info)
        subject.rules.check(member, allowed, value, lambda drive: device.read_back(drive.name))
        if is_led(subject, info):
            _lead(subject, device, info, value)
        else:
            device.set(info.name, value)
    return set_points


def is_led(subject: DeviceSubject, info: DriveInfo) -> bool:
    """Return whether the station requires a lower rate than that of the drive."""
    return subject.rules.is_led(Member(subject.role, info.name), info)


def _lead(subject: DeviceSubject, device: Settable, info: DriveInfo, value: float) -> None:
    """Set a drive in small steps, no faster than the station allows."""
    rate_per_s = subject.rules.narrowed(Member(subject.role, info.name), info).rate_per_s
    if rate_per_s is None:
        raise NotApplicable(f"{info.name} is moved in steps, but its rate is not known")
    clock, start = subject.clock(), device.read_back(info.name)
    steps = max(1, math.ceil(abs(value - start) / (rate_per_s * LEAD_S)))
    for step in range(1, steps + 1):
        clock.sleep(LEAD_S)
        device.set(info.name, start + (value - start) * step / steps)


def streamed_blocks(device: Device, duration_s: float) -> list[Block]:
    """Return the blocks of a stream of that duration."""
    return list(streamer(device).stream(streamed_names(device), duration_s, threading.Event()))


def actual_if_off(device: Settable, info: DriveInfo, value: float) -> float | None:
    """Return where the drive is, if it is not at the value within its tolerance."""
    actual = device.read_back(info.name)
    return None if abs(actual - value) <= info.allowed_deviation else actual
