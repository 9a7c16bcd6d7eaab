"""Check a mapping, its procedure and its station, without reading samples."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC
from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, PluginError, UsageError
from rigrunner.clock import SimulatedClock
from rigrunner.run.approval import ApprovalState
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.prepare import plan_run
from rigrunner.station import load_station
from rigrunner.tools.importing.columns import fault
from rigrunner.tools.importing.mapping import IMPORTER
from rigrunner.tools.importing.matching import match
from rigrunner.yamlfile import validate

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.importing import Importer
    from rigrunner.registry import Registry
    from rigrunner.run.prepare import Planned
    from rigrunner.tools.importing.mapping import LoadedMapping
    from rigrunner.tools.importing.matching import Matched


@dataclass(frozen=True, eq=False)
class PlannedImport:
    """An import after all checks that need no sample."""

    mapping: LoadedMapping
    planned: Planned
    matched: Matched
    importer: Importer
    reader: str
    """The importer's name and its provider."""


def plan_import(
    mapping: LoadedMapping, registry: Registry, station: Path | None = None
) -> PlannedImport:
    """Check a mapping, its procedure and its station against each other, as on the day of the run.

    `station` replaces the mapping's own. Raises InvalidFileError with all problems, and UsageError
    if the mapping names a station with its own plugins: a folder of files from elsewhere must not
    choose which code is run.
    """
    model = mapping.model
    procedure = _find_file(mapping, "procedure", model.procedure)
    station_path = station or _find_file(mapping, "station", model.station)
    if station is None and load_station(station_path).model.plugins is not None:
        raise UsageError(
            f"the station {station_path} has plugins of its own",
            hint=f"say that you trust them: --station {station_path}",
        )
    planned = plan_run(procedure, station_path, registry, SimulatedClock(model.started))
    state, day = planned.approval, model.started.astimezone(UTC).date().isoformat()
    if not state.is_draft and state.utc[:10] > day:  # a later approval does not count for it
        note = f"it was approved by {state.by} on {state.utc[:10]}, after the recordings were made"
        draft = ApprovalState("draft", sha256=state.sha256, note=note)
        planned = replace(planned, approval=draft)
    importer, reader = _make_importer(mapping, planned.registry)
    matched = match(mapping, planned)
    for path, part in model.parts():
        if not mapping.file(part.file).is_file():
            message = f"there is no file '{part.file}' in {mapping.path.parent}"
            raise fault(mapping, (*path, "file"), message)
    return PlannedImport(mapping, planned, matched, importer, reader)


def _find_file(mapping: LoadedMapping, key: str, name: str) -> Path:
    """Return the procedure or station of that name: beside the mapping, or a shipped one."""
    path = mapping.file(name)
    if path.is_file():
        return path
    find = find_procedure if key == "procedure" else find_station
    try:
        return find(name)
    except UsageError as error:
        raise fault(mapping, (key,), error.message, error.hint) from error


def _make_importer(mapping: LoadedMapping, registry: Registry) -> tuple[Importer, str]:
    name = mapping.model.format.name
    try:
        plugin = registry.find(IMPORTER, name)
        validate(plugin.record.settings_model, mapping.document, ("format", name))
        importer = registry.make(IMPORTER, name, mapping.model.format.settings)
    except InvalidFileError:
        raise
    except PluginError as error:
        raise fault(mapping, ("format",), error.message, error.hint) from error
    return importer, f"{name} of {plugin.provider}"
