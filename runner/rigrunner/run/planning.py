"""From two files to a planned run, with the clock that suits the station."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from pydantic import ValidationError

from rigrunner.api.errors import PluginError
from rigrunner.clock import SimulatedClock, WallClock
from rigrunner.registry import load_registry
from rigrunner.run.prepare import plan_run_in

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.devices import Clock
    from rigrunner.registry import Registry
    from rigrunner.run.prepare import Planned
    from rigrunner.station import LoadedStation, Station
    from rigrunner.tape import Tape


def planned_run(
    procedure: Path,
    station: Path,
    *,
    realtime: bool = False,
    tape: Tape | None = None,
    time_limits: bool = True,
    text: str | None = None,
) -> Planned:
    """Load, check and plan; raise InvalidFileError with all problems.

    `text` replaces the content of the file of the procedure: unsaved text of an editor. The day of
    a replay is that of its tape; calibrations and partner runs are checked for it.
    """

    def time(loaded: LoadedStation, registry: Registry) -> Clock:
        if tape is not None and tape.began_utc is not None:
            return SimulatedClock(tape.began_utc)
        return clock_for(loaded.model, registry, realtime=realtime)

    registry = load_registry()
    return plan_run_in(procedure, station, registry, time, tape, time_limits=time_limits, text=text)


def clock_for(station: Station, registry: Registry, *, realtime: bool) -> Clock:
    """Return a simulated clock for a fully simulated station, unless real time is wanted.

    Unknown plugins are left to the checks of the plan, which know their lines.
    """
    with suppress(PluginError, ValidationError):
        devices = station.devices.values()
        simulated = all(registry.is_simulated(entry.plugin, entry.settings) for entry in devices)
        return SimulatedClock() if simulated and not realtime else WallClock()
    return WallClock()
