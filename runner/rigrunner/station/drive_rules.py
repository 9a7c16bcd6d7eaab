"""Limits that apply when a drive is set: range and combination, of device and station."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceRejectedError
from rigrunner.api.quantity import legible

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigrunner.api.devices import DriveInfo
    from rigrunner.api.member import Member
    from rigrunner.station.limits import Combination, DriveLimits


@dataclass(frozen=True)
class DriveRules:
    """Limits of a station for its drives, by 'role.drive'."""

    drives: Mapping[Member, DriveLimits] = field(default_factory=dict)
    combinations: Sequence[Combination] = ()

    def narrowed(self, member: Member, info: DriveInfo) -> DriveInfo:
        """Return the drive with the limits of the station."""
        limits = self.drives.get(member)
        return info if limits is None else limits.narrowed(info)

    def is_led(self, member: Member, info: DriveInfo) -> bool:
        """Return whether the station wants a lower rate than that of the drive."""
        return self.narrowed(member, info).rate_per_s != info.rate_per_s

    def check(
        self, member: Member, allowed: DriveInfo, value: float, standing: Callable[[Member], float]
    ) -> None:
        """Raise DeviceRejectedError for a set-point outside the limits.

        `allowed` is the drive as `narrowed`; `standing` returns the value of another drive, in SI
        units.
        """
        if not allowed.minimum <= value <= allowed.maximum:
            raise DeviceRejectedError(
                f"{_title(member)}: {legible(value, allowed.unit)} is out of range"
                f" ({allowed.range_text})"
            )
        for combination in self.combinations:
            if member not in combination.drives:
                continue
            values = {n: value if n == member else standing(n) for n in combination.drives}
            if not combination.allows(values):
                set_point = legible(value, allowed.unit)
                others = combination.others(member, values)
                raise DeviceRejectedError(
                    f"{_title(member)} cannot be set to {set_point} with {others}",
                    hint=f"allowed: {combination.words()}",
                )


def _title(member: Member) -> str:
    return f"{member.role}: {member.name}"
