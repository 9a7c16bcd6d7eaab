"""The summary of a run for an index, read without its samples and events.

An index reads a whole folder of run files, so this reads only what it returns. It does not check
that the samples are those that were sealed; `read` and `rigrunner verify` do.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import h5py

from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import open_file, refuse_external
from rigrunner.runfile.added_units import define_units_of
from rigrunner.runfile.codec import check_format
from rigrunner.runfile.entry import FORMAT_ATTRIBUTE
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.hdf5 import read_text, read_values
from rigrunner.runfile.loose import read_loose_info
from rigrunner.runfile.manifest import MANIFEST, manifest_sha256
from rigrunner.runfile.model import DRAFT
from rigrunner.runfile.probe import refuse_unprotected_crashing
from rigrunner.runfile.reading import ENTRY, sealed_file_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

_LONGEST = 1 << 28
"""Longest text, in bytes: a longer one in a foreign file is not read."""


@dataclass(frozen=True, kw_only=True)
class RunSummary:
    """Identity, end and first result of a stored run."""

    sealed: bool
    run_id: str
    started_utc: str
    ended_utc: str
    outcome: str
    reason: str
    procedure_id: str
    procedure_revision: str
    procedure_title: str
    station_id: str
    inputs: Mapping[str, str]
    people: Mapping[str, str]
    provenance: Mapping[str, str]
    imported: Mapping[str, str]
    approval: Mapping[str, str]
    zeros: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    """The latest zero reading of each zeroed channel, with its unit."""
    recordings: int
    """The number of finished recordings."""
    digest: str
    """SHA-256 over recordings and measurements, as stored in the file."""
    manifest_sha256: str = ""
    """Empty without a manifest."""
    result_document: Mapping[str, Any] | None = None
    """The first analysis, as in `result.json`."""


def read_summary(path: Path) -> RunSummary:
    """Read the summary of a run folder, sealed or not; raise DataError."""
    sealed = sealed_file_of(path)
    if sealed is None:
        return _of_loose(RunFolder(path))
    refuse_unprotected_crashing(sealed)
    with open_file(sealed) as file:
        if FORMAT_ATTRIBUTE not in file.attrs:
            raise DataError(f"{sealed} is an HDF5 file, but not a run of Rigrunner")
        check_format(int(file.attrs[FORMAT_ATTRIBUTE]), str(sealed))
        return _of_entry(_group(file, ENTRY))


def _of_entry(entry: h5py.Group) -> RunSummary:
    # Each member is checked where it is read: `objects` would walk through the whole file.
    if MANIFEST in entry:
        _checked_text(entry, MANIFEST)
    run_id, provenance = read_text(entry, "run_id"), _texts(entry, "provenance")
    define_units_of(provenance, run_id)
    zeros = _group(entry, "zeros")
    for name in zeros:
        _member(zeros, name)
    values, units = read_values(zeros)
    return RunSummary(
        sealed=True,
        run_id=run_id,
        started_utc=read_text(entry, "started_utc"),
        ended_utc=read_text(entry, "ended_utc"),
        outcome=read_text(entry, "outcome"),
        reason=read_text(entry, "reason"),
        procedure_id=read_text(entry, "procedure_id"),
        procedure_revision=read_text(entry, "procedure_revision"),
        procedure_title=read_text(entry, "procedure_title"),
        station_id=read_text(entry, "station_id"),
        inputs=_texts(entry, "inputs"),
        people=_texts(entry, "people"),
        provenance=provenance,
        imported=_texts(entry, "imported"),
        approval=_texts(entry, "approval") or dict(DRAFT),
        zeros={name: (value, units.get(name, "")) for name, value in values.items()},
        recordings=len(_group(entry, "recordings")),
        digest=str(entry.attrs["sha256"]),
        manifest_sha256=manifest_sha256(entry),
        result_document=_document(entry),
    )


def _of_loose(files: RunFolder) -> RunSummary:
    info = read_loose_info(files)
    header = info.header
    return RunSummary(
        sealed=False,
        run_id=header.run_id,
        started_utc=header.started_utc,
        ended_utc=info.ended_utc,
        outcome=info.outcome,
        reason=info.reason,
        procedure_id=header.procedure_id,
        procedure_revision=header.procedure_revision,
        procedure_title=header.procedure_title,
        station_id=header.station_id,
        inputs=header.inputs,
        people=header.people,
        provenance=header.provenance,
        imported=header.imported,
        approval=header.approval,
        recordings=len(info.recording_names),
        digest=info.digest,
    )


def _document(entry: h5py.Group) -> dict[str, Any] | None:
    if "analysis" not in entry:
        return None
    group = _group(entry, "analysis")
    if "result" not in group.attrs:
        _checked_text(group, "result")
    document = json.loads(read_text(group, "result"))
    if not isinstance(document, dict):
        raise DataError(f"{entry.file.filename}: the result in it is not a result document")
    return document


def _texts(entry: h5py.Group, name: str) -> dict[str, str]:
    if name not in entry:
        return {}
    group = _group(entry, name)
    items = [_group(group, key) for key in group]
    return {read_text(item, "name"): read_text(item, "text") for item in items}


def _checked_text(group: h5py.Group, name: str) -> None:
    item = _member(group, name)
    if not isinstance(item, h5py.Dataset) or item.nbytes > _LONGEST:
        raise DataError(f"{group.file.filename}: {group.name}/{name} is not a text")


def _group(parent: h5py.Group, name: str) -> h5py.Group:
    item = _member(parent, name)
    if not isinstance(item, h5py.Group):
        raise DataError(f"{parent.file.filename}: {parent.name}/{name} is not a group")
    return item


def _member(group: h5py.Group, name: str) -> h5py.Group | h5py.Dataset:
    """Return a member that is in this very file: a link could lead anywhere."""
    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise DataError(f"{group.file.filename}: {group.name}/{name} is a link, not data")
    item = group[name]
    if isinstance(item, h5py.Dataset):
        refuse_external(item)
    return item
