"""Check a station without a procedure, and prepare its manual use."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from rigrunner.api.member import role_of
from rigrunner.clock import SimulatedClock
from rigrunner.plan import check_station, check_station_plugins
from rigrunner.registry import load_registry
from rigrunner.rig import Rig
from rigrunner.rig.messages import DeviceMessages
from rigrunner.run.guardian.guarding import guarding
from rigrunner.run.lab_plugins import load_with_plugins
from rigrunner.run.planning import clock_for
from rigrunner.run.prepare import make_devices, patience_of
from rigrunner.run.rig_lock import station_lock
from rigrunner.run.taping import manifest_of
from rigrunner.station.drive_rules import DriveRules
from rigrunner.tape import ReplayedTape

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping
    from contextlib import AbstractContextManager
    from pathlib import Path

    from rigrunner.api.devices import Clock, Device
    from rigrunner.plan.actions import Interlock
    from rigrunner.registry import Registry
    from rigrunner.rig import Pulse
    from rigrunner.rig_state import RigMarks
    from rigrunner.run.guardian.guarding import Guardian
    from rigrunner.station import LoadedStation
    from rigrunner.tape import Tape


@dataclass(frozen=True, eq=False)
class ReadyStation:
    """A station with its devices created. No instrument was accessed yet."""

    station: LoadedStation
    registry: Registry
    devices: Mapping[str, Device]
    interlocks: tuple[Interlock, ...]
    clock: Clock
    tape: Tape | None = None
    marks: RigMarks | None = None
    """The marker of the energised rig; None until the rig is held, and for simulators."""
    messages: DeviceMessages = field(default_factory=DeviceMessages)
    """Messages of the device drivers beside their answers."""

    def rig(self, roles: Collection[str], pulse: Pulse | None = None) -> Rig:
        """Return the devices of these roles as a rig, with the station's rules and order."""
        safety = self.station.model.safety
        devices = {role: device for role, device in self.devices.items() if role in roles}
        order = [member for member in safety.order if role_of(member) in devices]
        rules = DriveRules(safety.drives, safety.combinations)
        patience = patience_of(self.station)
        rig = Rig(devices, self.clock, patience, order, rules, marks=self.marks, pulse=pulse)
        rig.messages = self.messages
        return rig

    def guarded(self, what: str, roles: Collection[str]) -> AbstractContextManager[Guardian | None]:
        """Start a guardian for these roles of the rig, which is held."""
        patience = patience_of(self.station)
        rig = (self.station, self.registry, self.marks, patience)
        return guarding(*rig, what, messages=self.messages, roles=roles)

    @contextmanager
    def hold(self, what: str) -> Iterator[ReadyStation]:
        """Hold the rig for this process, and the tape if there is one; yield the devices.

        Raises DeviceError if another process has the rig.
        """
        if self.tape is None:
            with self._lock(what) as marks:
                yield replace(self, marks=marks)
            return
        with self.tape:
            self.tape.begin(manifest_of(self.station, self.registry, self.clock.utc()))
            ready = replace(self, clock=self.tape.clock(self.clock))
            if self.tape.replays:
                yield ready
                return
            with self._lock(what) as marks:
                yield replace(ready, marks=marks)

    def _lock(self, what: str) -> AbstractContextManager[RigMarks | None]:
        return station_lock(self.station, self.registry, what)


def ready_station(
    path: Path, *, realtime: bool = False, tape: Tape | None = None, time_limits: bool = True
) -> ReadyStation:
    """Load a station and create its devices; raise InvalidFileError with all problems."""
    loaded, registry = load_with_plugins(path, load_registry())
    station, messages = replace(loaded, time_limits=time_limits), DeviceMessages()
    check_station_plugins(station, registry)
    clock = clock_for(station.model, registry, realtime=realtime)
    if isinstance(tape, ReplayedTape):
        clock = SimulatedClock(tape.manifest.began_utc)
    devices = make_devices(station, registry, clock, path.parent, tape, messages=messages)
    interlocks = check_station(station, devices)
    return ReadyStation(station, registry, devices, interlocks, clock, tape, messages=messages)
