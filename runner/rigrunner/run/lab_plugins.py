"""Available plugins: installed ones, and those in the folder of a lab."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, PluginError, Problem
from rigrunner.registry import load_registry, with_drop_ins
from rigrunner.run.locate import find_station
from rigrunner.station import InconsistentStationError, load_station

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.registry import Registry
    from rigrunner.station import LoadedStation


def lab_registry(station: str | None) -> Registry:
    """Return the installed plugins and those in the folder of the station, if given."""
    registry = load_registry()
    if station is None:
        return registry
    return load_with_plugins(find_station(station), registry)[1]


def load_with_plugins(path: Path, registry: Registry) -> tuple[LoadedStation, Registry]:
    """Return a station, and the registry with the plugins of the lab; raise InvalidFileError."""
    try:
        loaded = load_station(path)
    except InconsistentStationError as error:
        if error.loaded.model.plugins is None:
            raise
        registry = with_lab_plugins(registry, error.loaded, path.parent)
        return load_station(path), registry  # they may bring the units that it is written in
    return loaded, with_lab_plugins(registry, loaded, path.parent)


def plugin_folders(station: str | None) -> list[Path]:
    """Return the folder of the plugins of a lab, if a station is given and names one."""
    if station is None:
        return []
    path = find_station(station)
    folder = load_station(path).model.plugins
    return [] if folder is None else [path.parent / folder]


def with_lab_plugins(registry: Registry, station: LoadedStation, folder: Path) -> Registry:
    """Return the registry with the plugins of a lab, if its station names a folder.

    Raises InvalidFileError if the folder does not exist or is outside the folder of the station:
    a station from someone else must not choose the code that runs.
    """
    plugins_folder = station.model.plugins
    if plugins_folder is None:
        return registry
    try:
        return with_drop_ins(registry, _within(folder, plugins_folder))
    except PluginError as error:
        where = station.document.where(("plugins",))
        raise InvalidFileError([Problem(error.message, where, "plugins", error.hint)]) from error


def _within(folder: Path, name: str) -> Path:
    path = folder / name
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError) as error:  # links in a circle, a name with a null
        raise PluginError(f"'{name}' cannot be looked up") from error
    if not inside:
        hint = "plugins must be in the station's folder, or below"
        raise PluginError(f"'{name}' is outside this file's folder", hint=hint)
    return path
