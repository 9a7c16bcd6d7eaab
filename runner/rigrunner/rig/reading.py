"""What drivers give, looked at before it is used: who they are, and values that are numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rigrunner.api.devices import Identity, KnowsStream, Readable, Streaming
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.rig.drives import as_number

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigrunner.rig.role import Role

Found = tuple[dict[str, float], dict[str, str]]
"""Values and units by 'role.channel'."""


def refuse_unnamed(role: str, found: object) -> None:
    """Raise DeviceRejectedError unless a driver told who answered, in words."""
    if not isinstance(found, Identity) or not all(
        isinstance(text, str) for text in (found.maker, found.model, found.serial, found.firmware)
    ):
        raise DeviceRejectedError(f"{role}: connect gave {found!r}, which is no Identity")


def sample_rate_hz(role: Role) -> float:
    """Return the sample rate of a device that streams; raise DeviceRejectedError for none."""
    device = role.need(Streaming)  # type: ignore[type-abstract]  # a Protocol
    with role.named():
        rate_hz = as_number(device.sample_rate_hz)
        if not 0 < rate_hz < math.inf:
            raise DeviceRejectedError(f"the driver gave a sample rate of {rate_hz:g} Hz")
    return rate_hz


def read(role: Role, channels: Sequence[str], answer_s: float) -> dict[str, float]:
    """Return the present value of each channel; raise a DeviceError."""
    device = role.need(Readable)  # type: ignore[type-abstract]  # a Protocol
    values = role.call("read", device.read, answer_s, channels)
    found = {}
    try:
        for name in channels:
            value = values.get(name, math.nan)
            if type(value) is not float:  # as of most drivers
                value = as_number(value)
            if math.isfinite(value):
                found[f"{role.name}.{name}"] = value
    except (DeviceRejectedError, AttributeError) as error:
        raise DeviceRejectedError(
            f"{role.name}: the driver gave {values!r}", hint="a number of each channel is needed"
        ) from error
    missing = [name for name in channels if f"{role.name}.{name}" not in found]
    if missing:
        raise DeviceRejectedError(f"{role.name}: no value was read of {', '.join(missing)}")
    return found


def read_beside(
    roles: Iterable[Role], streamed: Mapping[str, Sequence[str]], answer_s: float
) -> Found:
    """Read once all that can be read beside the channels that a role streams."""
    values: dict[str, float] = {}
    units: dict[str, str] = {}
    for role in roles:
        if role.able(Readable) is not None:  # type: ignore[type-abstract]  # a Protocol
            busy = streamed.get(role.name, ())
            channels = role.device.channels
            wanted = {info.name: info.unit for info in channels if info.name not in busy}
            values |= read(role, tuple(wanted), answer_s)
            units |= {f"{role.name}.{channel}": unit for channel, unit in wanted.items()}
    return values, units


def found_of_stream(role: Role, answer_s: float) -> Found:
    """Return what a device found of its last stream; nothing where it finds out nothing."""
    device = role.able(KnowsStream)  # type: ignore[type-abstract]  # a Protocol
    if device is None:
        return {}, {}
    found = role.call("tell of the stream", device.stream_conditions, answer_s)
    values = {f"{role.name}.{name}": as_number(value) for name, (value, _) in found.items()}
    return values, {f"{role.name}.{name}": unit for name, (_, unit) in found.items()}
