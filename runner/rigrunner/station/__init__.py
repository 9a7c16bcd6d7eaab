"""The station: devices, rig description and instrument register."""

from __future__ import annotations

from rigrunner.station.loading import (
    InconsistentStationError,
    LoadedStation,
    load_station,
    parse_station,
)
from rigrunner.station.model import DeviceBinding, ListenerBinding, Station

__all__ = [
    "DeviceBinding",
    "InconsistentStationError",
    "ListenerBinding",
    "LoadedStation",
    "Station",
    "load_station",
    "parse_station",
]
