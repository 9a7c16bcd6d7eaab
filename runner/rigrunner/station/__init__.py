"""The station: devices, rig description and instrument register."""

from __future__ import annotations

from rigrunner.station.loading import LoadedStation, load_station, parse_station
from rigrunner.station.model import DeviceBinding, ListenerBinding, Station

__all__ = [
    "DeviceBinding",
    "ListenerBinding",
    "LoadedStation",
    "Station",
    "load_station",
    "parse_station",
]
