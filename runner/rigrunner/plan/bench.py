"""The station's devices in the roles of a procedure: what can be read, recorded and set."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.devices import (
    ChannelInfo,
    DriveInfo,
    Observing,
    Readable,
    ReadableInPlaces,
    Streaming,
)
from rigrunner.api.member import Member
from rigrunner.api.units import find_unit, unit, with_article
from rigrunner.station.drive_rules import DriveRules
from rigrunner.yamlfile.problems import suggestion

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.devices import Device, ReadingInfo
    from rigrunner.api.quantity import Quantity
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile.document import Path
    from rigrunner.yamlfile.problems import Problems

Info = TypeVar("Info", ChannelInfo, DriveInfo)


class Bench:
    """Looks up channels and drives by `role.name`; what is not there is added to the problems."""

    def __init__(
        self,
        procedure: LoadedProcedure,
        devices: Mapping[str, Device],
        problems: Problems,
        rules: DriveRules | None = None,
    ) -> None:
        self.rules = rules or DriveRules()
        self._uses = procedure.model.uses
        self._document = procedure.document
        self._devices = devices
        self._problems = problems
        self._readings = {
            Member(role, info.name): info
            for role, device in devices.items()
            if role in self._uses and isinstance(device, Observing)
            for info in device.readings
        }
        # Asked once: such a check of a protocol takes longer than all else that a step looks up.
        self._readable = [role for role, device in devices.items() if isinstance(device, Readable)]
        self._in_places = {
            role: device for role, device in devices.items() if isinstance(device, ReadableInPlaces)
        }

    def of(self, procedure: LoadedProcedure) -> Bench:
        """Return the same bench as another procedure sees it."""
        return Bench(procedure, self._devices, self._problems, self.rules)

    def channel(self, member: Member, path: Path, *, key: bool = False) -> ChannelInfo | None:
        """Return the channel, or None after adding the problem; `key`: it is named by a key."""
        device = self._device(member, path, key=key)
        if device is None:
            return None
        return self._find(device.channels, "channel", member, path, key=key)

    @cached_property
    def shown_in(self) -> Mapping[str, str]:
        """The unit in which people see each channel, 'role.name', where it says one."""
        return {
            Member(role, info.name): info.shown_in
            for role, device in self._devices.items()
            for info in device.channels
            if info.shown_in
        }

    def reading(self, member: Member) -> ReadingInfo | None:
        """Return a reading of a role's device that is not a number; None for any other name."""
        return self._readings.get(member)

    def drive(self, member: Member, path: Path, *, key: bool) -> DriveInfo | None:
        """Return the drive, or None after adding the problem; `key`: it is named by a key."""
        device = self._device(member, path, key=key)
        if device is None:
            return None
        info = self._find(device.drives, "drive", member, path, key=key)
        return None if info is None else self.rules.narrowed(member, info)

    def safe_value(self, member: Member) -> float:
        """Return the safe value of a drive of the station."""
        drives = self._devices[member.role].drives
        return next(info.safe_value for info in drives if info.name == member.name)

    def cycle_drives(self) -> list[Member]:
        """Return all drives, 'role.name', that set the frequency of a cyclic motion."""
        return [
            Member(role, drive.name)
            for role in self._uses
            if role in self._devices
            for drive in self._devices[role].drives
            if drive.sets_cycle_frequency
        ]

    def sample_rate_hz(self, role: str, path: Path) -> float | None:
        """Return the rate at which a role's device streams, or None after adding the problem."""
        device = self._devices.get(role)
        if isinstance(device, Streaming):
            return device.sample_rate_hz
        if device is not None:
            message = f"the device in the role '{role}' cannot record"
            self._problems.add(self._document, path, message, "record channels of another device")
        return None

    def can_record(self, member: Member, path: Path) -> bool:
        """Say whether a channel that is there is streamed; add the problem if it is only read.

        A device that streams nothing is reported by `sample_rate_hz`.
        """
        if self.streams(member) or not isinstance(self._device_of(member), Streaming):
            return True
        message = f"{member} cannot be recorded: it is read as a single value"
        hint = "each recording stores it as a condition; 'measure' reads it"
        self._problems.add(self._document, path, message, hint)
        return False

    def must_be_readable(self, role: str, path: Path) -> None:
        """Add a problem if single values of a role's device cannot be read."""
        device = self._devices.get(role)
        if device is not None and role not in self._readable:
            message = f"the device in the role '{role}' gives no single values"
            hint = "give a duration to average" if isinstance(device, Streaming) else ""
            self._problems.add(self._document, path, message, hint)

    def is_readable_at(self, role: str, set_points: Mapping[str, float], path: Path) -> bool:
        """Say whether a role's device can be read at set-points, 'role.drive'; add the problem.

        A drive that is not among them stands at its safe value.
        """
        device = self._in_places.get(role)
        if device is None:
            return True
        own_set_points = {
            info.name: set_points.get(Member(role, info.name), info.safe_value)
            for info in device.drives
        }
        if any(not d.minimum <= own_set_points[d.name] <= d.maximum for d in device.drives):
            return True  # it is a problem of the set-point
        reason = device.unreadable_at(own_set_points)
        if reason is not None:
            message = f"{role} cannot be read here: {reason.message}"
            self._problems.add(self._document, path, message, reason.hint)
        return reason is None

    def conditions(self, role: str, streamed: Sequence[str]) -> list[Member]:
        """Return all channels, 'role.name', that are read beside what a role's device streams."""
        return [
            Member(name, channel.name)
            for name, device in self._devices.items()
            if isinstance(device, Readable)
            for channel in device.channels
            if name != role or channel.name not in streamed
        ]

    def streams(self, member: Member) -> bool:
        """Say whether a channel is one that its device streams."""
        device, name = self._device_of(member), member.name
        streamed = [info.streams for info in device.channels if info.name == name] if device else []
        return isinstance(device, Streaming) and all(streamed)

    def _device_of(self, member: Member) -> Device | None:
        return self._devices.get(member.role)

    def fits(self, quantity: Quantity, symbol: str, member: Member, path: Path) -> bool:
        """Say whether a quantity has the dimension of a unit; add the problem if not."""
        dimension = unit(symbol).dimension
        if quantity.dimension == dimension:
            return True
        got = f"got '{quantity}', {with_article(quantity.dimension)}"
        message = f"{got}; {member} takes {with_article(dimension)}"
        self._problems.add(self._document, path, message, f"write it in {symbol}")
        return False

    def _device(self, member: Member, path: Path, *, key: bool) -> Device | None:
        role = member.role
        if role in self._uses:
            return self._devices.get(role)
        hint = suggestion(role, self._uses, "roles under 'uses'")
        message = f"'{member}': the procedure uses no role '{role}'"
        self._problems.add(self._document, path, message, hint, key=key)
        return None

    def _find(
        self, infos: Sequence[Info], what: str, member: Member, path: Path, *, key: bool
    ) -> Info | None:
        role, name = member.role, member.name
        by_name = {info.name: info for info in infos}
        info = by_name.get(name)
        if info is not None and find_unit(info.unit):
            return info
        if info is not None:
            message = (
                f"the device gives {what} '{name}' in '{info.unit}', which is not a known unit"
            )
            hint = "report it to the author of the device's plugin"
        elif reading := self.reading(member):
            message, hint = f"{member} is not a number: {reading.kind}", "'measure' reads it"
        else:
            message = f"the device in the role '{role}' has no {what} '{name}'"
            hint = suggestion(name, by_name, f"{what}s")
        self._problems.add(self._document, path, message, hint, key=key)
        return None


def check_roles(
    procedure: LoadedProcedure, station: LoadedStation, problems: Problems
) -> frozenset[str]:
    """Add a problem for every role that the station does not fill with a device of its type.

    Returns the roles that a device of another type fills: it would have a problem at each step.
    """
    devices, other_types = station.model.devices, set()
    for role, device_type in procedure.model.uses.items():
        path, document = ("uses", role), procedure.document
        if role not in devices:
            message = f"station '{station.model.id}' has no device in the role '{role}'"
            problems.add(document, path, message, suggestion(role, devices, "roles"), key=True)
        elif devices[role].type != device_type:
            message = f"a {device_type} is needed, station '{station.model.id}' has a "
            hint = f"the role is assigned at {station.document.where(('devices', role, 'type'))}"
            problems.add(document, path, message + devices[role].type, hint)
            other_types.add(role)
    return frozenset(other_types)
