"""Checks of what drivers return: identities, and values that are numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.devices import Identity, KnowsStream, Observing, Readable, Streaming
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.api.member import Member
from rigrunner.api.texts import visible
from rigrunner.rig.drives import as_number

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api.readings import Reading
    from rigrunner.rig.role import Role

Found = tuple[dict[str, float], dict[str, str]]
"""Values and units by 'role.channel'."""
_NEEDED = {"text": "a str", "boolean": "a bool", "array": "a tuple of finite numbers"}


def refuse_unnamed(role: str, found: object) -> None:
    """Raise DeviceRejectedError unless a driver returned an identity as text."""
    if not isinstance(found, Identity) or not all(
        isinstance(text, str) for text in (found.maker, found.model, found.serial, found.firmware)
    ):
        raise DeviceRejectedError(f"{role}: connect gave {found!r}, which is not an Identity")


def plain_identity(found: Identity) -> Identity:
    """Return an identity without hidden characters, which an instrument may have answered."""
    return replace(
        found,
        maker=visible(found.maker),
        model=visible(found.model),
        serial=visible(found.serial),
        firmware=visible(found.firmware),
        parts={name: plain_identity(part) for name, part in found.parts.items()},
    )


def sample_rate_hz(role: Role) -> float:
    """Return the sample rate of a streaming device; raise DeviceRejectedError if invalid."""
    device = role.need(Streaming)  # type: ignore[type-abstract]  # a Protocol
    with role.named():
        rate_hz = as_number(device.sample_rate_hz)
        if not 0 < rate_hz < math.inf:
            raise DeviceRejectedError(f"the driver gave a sample rate of {rate_hz:g} Hz")
    return rate_hz


class HeldChannels:
    """Reads channels of a connected device repeatedly."""

    def __init__(self, role: Role, channels: Sequence[str], answer_s: float) -> None:
        """Look up the channels; raise DeviceRejectedError if single values cannot be read."""
        self._role = role
        self._channels = channels
        self._members = tuple((name, Member(role.name, name)) for name in channels)
        self._count = len(set(channels))
        self._read = role.need(Readable).read  # type: ignore[type-abstract]  # a Protocol
        self._answer_s = answer_s

    def read(self) -> dict[str, float]:
        """Return the present value of each channel by 'role.channel'; raise a DeviceError."""
        values = self._role.call("read", self._read, self._answer_s, self._channels)
        found: dict[str, float] = {}
        try:
            for name, member in self._members:
                value = as_number(values.get(name, math.nan))
                if math.isfinite(value):
                    found[member] = value
        except (DeviceRejectedError, AttributeError) as error:
            raise DeviceRejectedError(
                f"{self._role.name}: the driver gave {values!r}",
                hint="a number of each channel is needed",
            ) from error
        if len(found) != self._count:
            missing = [name for name, member in self._members if member not in found]
            text = f"{self._role.name}: no value was read of {', '.join(missing)}"
            raise DeviceRejectedError(text)
        return found


def told(role: Role, names: Sequence[str], answer_s: float) -> dict[str, Reading]:
    """Return the checked readings that are not numbers; raise a DeviceError."""
    device = role.need(Observing)  # type: ignore[type-abstract]  # a Protocol
    kinds = {info.name: info.kind for info in device.readings}
    values = role.call("read", device.observe, answer_s, names)
    return {Member(role.name, name): _told(role, name, kinds[name], values) for name in names}


def _told(role: Role, name: str, kind: str, values: Mapping[str, object]) -> Reading:
    value = values.get(name) if isinstance(values, Mapping) else None
    if kind == "text" and isinstance(value, str):
        return value
    if kind == "boolean" and isinstance(value, bool):
        return value
    if kind == "array" and isinstance(value, (tuple, list)):
        with role.named():
            numbers = tuple(as_number(each) for each in value)
        if all(map(math.isfinite, numbers)):
            return numbers
    raise DeviceRejectedError(
        f"{role.name}: the driver gave {value!r:.80} for '{name}'",
        hint=f"expected {_NEEDED[kind]}",
    )


def read_beside(
    roles: Iterable[Role], streamed: Mapping[str, Sequence[str]], answer_s: float
) -> Found:
    """Read once everything that can be read while a role streams."""
    values: dict[str, float] = {}
    units: dict[str, str] = {}
    for role in roles:
        if role.able(Readable) is not None:  # type: ignore[type-abstract]  # a Protocol
            busy = streamed.get(role.name, ())
            channels = role.device.channels
            wanted = {info.name: info.unit for info in channels if info.name not in busy}
            values |= HeldChannels(role, tuple(wanted), answer_s).read()
            units |= {Member(role.name, channel): unit for channel, unit in wanted.items()}
    return values, units


def found_of_stream(role: Role, answer_s: float) -> Found:
    """Return the values that a device measured of its last stream; empty for none."""
    device = role.able(KnowsStream)  # type: ignore[type-abstract]  # a Protocol
    if device is None:
        return {}, {}
    found = role.call("tell of the stream", device.stream_conditions, answer_s)
    values: dict[str, float] = {
        Member(role.name, name): as_number(value) for name, (value, _) in found.items()
    }
    return values, {Member(role.name, name): unit for name, (_, unit) in found.items()}
