"""Drives of a device that exists only in the program: limits, rates, and the safe state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DeviceRejectedError
from rigrunner.api.quantity import legible
from rigrunner_plugins.devices.channels import find

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigrunner.api import Clock, DriveInfo


class Drives:
    """Drives by name, in the order in which they are made safe; all start at their safe value."""

    def __init__(self, infos: Iterable[DriveInfo], clock: Clock) -> None:
        self._infos = {info.name: info for info in infos}
        self._clock = clock
        self._actual = {name: info.safe_value for name, info in self._infos.items()}

    @property
    def infos(self) -> Sequence[DriveInfo]:
        """What the drives are."""
        return tuple(self._infos.values())

    @property
    def actual(self) -> Mapping[str, float]:
        """The actual value of each drive."""
        return dict(self._actual)

    def set(self, name: str, value: float) -> None:
        """Move a drive at its rate; raise DeviceRejectedError for what it cannot do."""
        info = find("drive", name, self._infos)
        if not info.minimum <= value <= info.maximum:
            raise DeviceRejectedError(
                f"{name}: {legible(value, info.unit)} is out of range ({info.range_text})"
            )
        self._move(info, value)

    def read_back(self, name: str) -> float:
        """Return the actual value of a drive."""
        return find("drive", name, self._actual)

    def make_safe(self) -> Mapping[str, float]:
        """Bring all to their safe values, one after the other, and return the actual values."""
        for info in self._infos.values():
            self._move(info, info.safe_value)
        return self.actual

    def _move(self, info: DriveInfo, value: float) -> None:
        if info.rate_per_s:
            self._clock.sleep(abs(value - self._actual[info.name]) / info.rate_per_s)
        self._actual[info.name] = value
