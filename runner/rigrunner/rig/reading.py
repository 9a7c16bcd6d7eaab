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

Conditions = tuple[dict[str, float], dict[str, str]]
"""Values and units by 'role.channel'."""
_EXPECTED = {"text": "a str", "boolean": "a bool", "array": "a tuple of finite numbers"}


def check_identity(role: str, value: object) -> None:
    """Raise DeviceRejectedError unless a driver returned an identity as text."""
    if not isinstance(value, Identity) or not all(
        isinstance(text, str) for text in (value.maker, value.model, value.serial, value.firmware)
    ):
        raise DeviceRejectedError(f"{role}: connect gave {value!r}, which is not an Identity")


def plain_identity(identity: Identity) -> Identity:
    """Return an identity without hidden characters, which an instrument may have answered."""
    return replace(
        identity,
        maker=visible(identity.maker),
        model=visible(identity.model),
        serial=visible(identity.serial),
        firmware=visible(identity.firmware),
        parts={name: plain_identity(part) for name, part in identity.parts.items()},
    )


def sample_rate_hz(role: Role) -> float:
    """Return the sample rate of a streaming device; raise DeviceRejectedError if invalid."""
    device = role.need(Streaming)  # type: ignore[type-abstract]  # a Protocol
    with role.named():
        rate_hz = as_number(device.sample_rate_hz)
        if not 0 < rate_hz < math.inf:
            raise DeviceRejectedError(f"the driver gave a sample rate of {rate_hz:g} Hz")
    return rate_hz


class ChannelReader:
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
        readings: dict[str, float] = {}
        try:
            for name, member in self._members:
                value = as_number(values.get(name, math.nan))
                if math.isfinite(value):
                    readings[member] = value
        # AttributeError: the driver gave no mapping.
        except (DeviceRejectedError, AttributeError) as error:
            raise DeviceRejectedError(
                f"{self._role.name}: the driver gave {values!r}",
                hint="a number of each channel is needed",
            ) from error
        if len(readings) != self._count:
            missing = [name for name, member in self._members if member not in readings]
            text = f"{self._role.name}: no value was read of {', '.join(missing)}"
            raise DeviceRejectedError(text)
        return readings


def observe(role: Role, names: Sequence[str], answer_s: float) -> dict[str, Reading]:
    """Return the checked readings that are not numbers; raise a DeviceError."""
    device = role.need(Observing)  # type: ignore[type-abstract]  # a Protocol
    kinds = {info.name: info.kind for info in device.readings}
    values = role.call("read", device.observe, answer_s, names)
    return {Member(role.name, name): _checked(role, name, kinds[name], values) for name in names}


def _checked(role: Role, name: str, kind: str, values: Mapping[str, object]) -> Reading:
    value = values.get(name) if isinstance(values, Mapping) else None
    if kind == "text" and isinstance(value, str):
        return value
    if kind == "boolean" and isinstance(value, bool):
        return value
    if kind == "array" and isinstance(value, (tuple, list)):
        with role.named():
            numbers = tuple(as_number(number) for number in value)
        if all(map(math.isfinite, numbers)):
            return numbers
    raise DeviceRejectedError(
        f"{role.name}: the driver gave {value!r:.80} for '{name}'",
        hint=f"expected {_EXPECTED[kind]}",
    )


def read_conditions(
    roles: Iterable[Role], streamed: Mapping[str, Sequence[str]], answer_s: float
) -> Conditions:
    """Read once everything that can be read while a role streams."""
    values: dict[str, float] = {}
    units: dict[str, str] = {}
    for role in roles:
        if role.able(Readable) is not None:  # type: ignore[type-abstract]  # a Protocol
            busy = streamed.get(role.name, ())
            channels = role.device.channels
            unit_of = {info.name: info.unit for info in channels if info.name not in busy}
            values |= ChannelReader(role, tuple(unit_of), answer_s).read()
            units |= {Member(role.name, name): unit for name, unit in unit_of.items()}
    return values, units


def stream_conditions(role: Role, answer_s: float) -> Conditions:
    """Return the values that a device measured of its last stream; empty for none."""
    device = role.able(KnowsStream)  # type: ignore[type-abstract]  # a Protocol
    if device is None:
        return {}, {}
    answer = role.call("tell of the stream", device.stream_conditions, answer_s)
    values: dict[str, float] = {}
    units: dict[str, str] = {}
    try:
        for name, (value, unit) in answer.items():
            values[Member(role.name, name)] = as_number(value)
            units[Member(role.name, name)] = unit
    # AttributeError: the driver gave no mapping; TypeError, ValueError: a value is no pair.
    except (DeviceRejectedError, AttributeError, TypeError, ValueError) as error:
        raise _conditions_error(role, answer) from error
    if not all(map(math.isfinite, values.values())):
        raise _conditions_error(role, answer)
    return values, units


def _conditions_error(role: Role, answer: object) -> DeviceRejectedError:
    return DeviceRejectedError(
        f"{role.name}: the driver gave {answer!r} as conditions of its stream",
        hint="a finite number and a unit of each value are needed",
    )
