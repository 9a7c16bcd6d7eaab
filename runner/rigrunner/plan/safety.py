"""Checks that the safety section of a station names only devices and drives that it has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.member import Member
from rigrunner.api.units import rate_of, unit, units_of, with_article
from rigrunner.station.drive_rules import DriveRules
from rigrunner.yamlfile.problems import suggestion

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.devices import Device, DriveInfo
    from rigrunner.api.quantity import Quantity
    from rigrunner.station import LoadedStation
    from rigrunner.station.limits import Combination, DriveLimits
    from rigrunner.yamlfile.document import Path
    from rigrunner.yamlfile.problems import Problems


def check_order(station: LoadedStation, devices: Mapping[str, Device], problems: Problems) -> None:
    """Add a problem for every device and drive in the order of making safe that is not there."""
    lookup = _Drives(station, devices, problems)
    for index, member in enumerate(station.model.safety.order):
        path = ("safety", "order", index)
        if isinstance(member, Member):
            lookup.drive(member, path)
        else:
            lookup.device(member, path)


def drive_rules(
    station: LoadedStation, devices: Mapping[str, Device], problems: Problems
) -> DriveRules:
    """Return what the station allows of its drives; what does not fit them is a problem."""
    safety, lookup = station.model.safety, _Drives(station, devices, problems)
    drives = {name: each for name, each in safety.drives.items() if lookup.limits_fit(name, each)}
    fitting = [
        each for at, each in enumerate(safety.combinations) if lookup.combination_fits(at, each)
    ]
    return DriveRules(drives, fitting)


@dataclass(frozen=True, eq=False)
class _Drives:
    """Looks up the drives that the file of a station names."""

    station: LoadedStation
    devices: Mapping[str, Device]
    problems: Problems

    def complain(self, path: Path, message: str, hint: str = "", *, key: bool = False) -> None:
        self.problems.add(self.station.document, path, message, hint, key=key)

    def device(self, role: str, path: Path, *, key: bool = False) -> Device | None:
        """Return the device, or None after adding the problem; `key`: it is named by a key."""
        if role not in self.devices:
            message = f"there is no device in the role '{role}'"
            self.complain(path, message, suggestion(role, self.devices, "roles"), key=key)
        return self.devices.get(role)

    def drive(self, member: Member, path: Path, *, key: bool = False) -> DriveInfo | None:
        """Return the drive, or None after adding the problem."""
        role, name = member.role, member.name
        device = self.device(role, path, key=key)
        if device is None:
            return None
        drives = {info.name: info for info in device.drives}
        if name not in drives:
            message = f"the device in the role '{role}' has no drive '{name}'"
            self.complain(path, message, suggestion(name, drives, "drives"), key=key)
        return drives.get(name)

    def limits_fit(self, member: Member, limits: DriveLimits) -> bool:
        path = ("safety", "drives", member)
        drive = self.drive(member, path, key=True)
        if drive is None:
            return False
        dimension = unit(drive.unit).dimension
        of_rate = rate_of(dimension) or ""
        values = [("min", limits.min, dimension), ("max", limits.max, dimension)]
        fits = [
            self._has(expected, value, member, (*path, key))
            for key, value, expected in (*values, ("rate", limits.rate, of_rate))
            if value is not None
        ]
        return all(fits)  # after all problems were added

    def combination_fits(self, at: int, combination: Combination) -> bool:
        path = ("safety", "combinations", at, "allowed")
        fits = True
        for index, corner in enumerate(combination.allowed):
            for member, quantity in corner.items():
                place = (*path, index, member)
                drive = self.drive(member, place, key=True)
                # `fits` is last, so that every wrong corner is reported.
                fits = (
                    drive is not None
                    and self._has(unit(drive.unit).dimension, quantity, member, place)
                    and fits
                )
        return fits

    def _has(self, dimension: str, quantity: Quantity, member: Member, path: Path) -> bool:
        problem = wrong_dimension(quantity, dimension, member)
        if problem:
            self.complain(path, *problem)
        return not problem


def wrong_dimension(quantity: Quantity, dimension: str, member: Member) -> tuple[str, str] | None:
    """Return what is wrong with a quantity that a member takes, and a hint; None if it fits.

    `dimension` is '' for the rate of what has no unit for it.
    """
    if quantity.dimension == dimension:
        return None
    needed = f"takes {with_article(dimension)}" if dimension else "has no unit for its rate"
    hint = f"write it in {' or '.join(units_of(dimension))}" if dimension else ""
    return f"got '{quantity}', {with_article(quantity.dimension)}; {member} {needed}", hint
