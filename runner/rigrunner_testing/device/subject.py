"""A device plugin under test: a new device for each check, made safe afterwards."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rigrunner.api.devices import (
    Device,
    DeviceContext,
    DirectWire,
)
from rigrunner.api.hooks import DeviceRecord
from rigrunner.api.member import Member
from rigrunner.clock import SimulatedClock, WallClock
from rigrunner.rig import agrees
from rigrunner.station.drive_rules import DriveRules
from rigrunner_testing.subjects import Subject

if TYPE_CHECKING:
    from collections.abc import Generator

    from rigrunner.api.devices import Clock, DriveInfo, Wire
    from rigrunner.rig_state import RigMarks

CONNECT_S = 5.0
ROLE = "device"


@dataclass(frozen=True)
class DeviceSubject(Subject):
    """A device plugin; `made_devices` are those that a check has not yet closed."""

    folder: Path = field(default_factory=Path)
    """Base of relative paths in the settings."""
    role: str = ROLE
    rules: DriveRules = field(default_factory=DriveRules)
    """Limits that the station sets for the drives."""
    read_only: bool = False
    """Never move a drive, not even to its safe value."""
    marks: RigMarks | None = None
    """Marks of the rig; None without a station and for simulators."""
    made_devices: list[Device] = field(default_factory=list)

    @property
    def record(self) -> DeviceRecord:
        """The record of the plugin."""
        return self.record_as(DeviceRecord)

    @property
    def simulated(self) -> bool:
        """Whether the device is simulated; a wrapper is if the wrapped one is."""
        return self.registry.is_simulated(self.name, self.settings)

    def clock(self) -> Clock:
        """Return a simulated clock for a simulated device, else the wall clock."""
        return SimulatedClock() if self.simulated else WallClock()

    def make(
        self, *, clock: Clock | None = None, wire: Wire | None = None, **changes: Any
    ) -> Device:
        """Return a new device, not connected; raise PluginError."""
        context = DeviceContext(
            self.role, clock or self.clock(), self.folder, wire=wire or DirectWire()
        )
        settings = {**self.settings, **changes}
        device = self.registry.make_device(self.name, settings, context)
        self.made_devices.append(device)
        return device

    @contextmanager
    def connected(
        self, *, clock: Clock | None = None, wire: Wire | None = None, **changes: Any
    ) -> Generator[Device]:
        """Yield a connected device; make it safe and close it in any case."""
        device = self.make(clock=clock, wire=wire, **changes)
        if self.marks is not None and not self.read_only:
            self.marks.energise(self.role, device.drives)
        device.connect(CONNECT_S)
        try:
            yield device
        finally:
            self._give_back(device)

    def release(self) -> None:
        """Make safe and close devices that a failed or hanging check left open."""
        while self.made_devices:
            self._give_back(self.made_devices[-1])

    def drives_of(self, device: Device) -> list[DriveInfo]:
        """Return the drives with the limits of the station."""
        return [self.rules.narrowed(Member(self.role, info.name), info) for info in device.drives]

    def _give_back(self, device: Device) -> None:
        self.made_devices[:] = [other for other in self.made_devices if other is not device]
        if not self.read_only:
            with suppress(Exception):  # checks of their own look at making safe, the last one too
                read_back = device.make_safe()
                if self.marks is not None and all(
                    agrees(info, read_back[info.name], info.safe_value) for info in device.drives
                ):
                    self.marks.confirm([self.role])
        with suppress(Exception):
            device.close()
