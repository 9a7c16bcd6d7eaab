"""A whole run as a NeXus entry: the layout of `run.h5`, written and read in one place."""

from __future__ import annotations

import json
from array import array
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import members, open_file
from rigrunner.runfile.added_units import define_units_of
from rigrunner.runfile.attempts import superseded
from rigrunner.runfile.codec import event_text
from rigrunner.runfile.digest import run_digest
from rigrunner.runfile.elapsed import (
    cycles_by_recording,
    seconds_since,
    with_elapsed,
)
from rigrunner.runfile.hdf5 import (
    AsciiColumn,
    free_name,
    new_group,
    pieces_of,
    read_long,
    read_text,
    read_texts,
    read_values,
    write_long,
    write_text,
    write_texts,
    write_values,
    write_verbatim,
)
from rigrunner.runfile.journal import Kind
from rigrunner.runfile.loose import PART_GROUP
from rigrunner.runfile.manifest import manifest_sha256
from rigrunner.runfile.measurements import write_measurements
from rigrunner.runfile.model import DRAFT, RunHeader, RunInfo, StoredRun
from rigrunner.runfile.parts import parts_of, zeros_in_force
from rigrunner.runfile.recordings import read_recording, stored_bytes
from rigrunner.runfile.scratch import Scratch
from rigrunner.runfile.stored_events import StoredEvents
from rigrunner.runfile.stored_samples import IN_MEMORY

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    import h5py

    from rigrunner.api.data import Recording
    from rigrunner.api.details import RunPlot
    from rigrunner.runfile.loose import Journal

HEADER_TEXTS = (
    "run_id",
    "started_utc",
    "procedure_id",
    "procedure_revision",
    "procedure_title",
    "station_id",
)
VERBATIM, PLAN = ("procedure_text", "station_text"), "plan_text"
CALLED = "called"
SUPERSEDED = "superseded"
IMPORTED = "imported"
MAPPING = "mapping_text"
FORMAT_ATTRIBUTE = "rigrunner_format"
SALVAGED = "salvaged"
PARTNER = "NXsubentry"
"""The class of a partner run, which is embedded whole but for its own partners."""
KINDS = ("recordings", "incomplete", SUPERSEDED)
"""The groups of recordings; runs of earlier versions lack some."""
_PIECE = 1000
"""Events that are decoded at once."""
_END_TEXTS = ("ended_utc", "outcome", "reason")


def format_of(entry: h5py.Group) -> int:
    """Return the version of the layout: an embedded run has its own, any other that of the file."""
    version = entry.attrs.get(FORMAT_ATTRIBUTE)
    return int(entry.file.attrs[FORMAT_ATTRIBUTE] if version is None else version)


def write_entry(entry: h5py.Group, journal: Journal) -> None:
    """Write all but recordings and analysis into an empty entry."""
    header, rows = journal.header, journal.events.measured
    write_text(entry, "title", header.procedure_title)
    for name in HEADER_TEXTS:
        write_text(entry, name, getattr(header, name))
    for name, text in zip(_END_TEXTS, journal.end(), strict=True):
        write_text(entry, name, text)
    texts = new_group(entry, "texts", "NXcollection")
    for name in VERBATIM:
        write_verbatim(texts, name, getattr(header, name))
    write_long(texts, PLAN, header.plan_text)
    write_texts(texts, CALLED, header.called_texts)
    write_texts(entry, "inputs", header.inputs)
    write_texts(entry, "provenance", header.provenance)
    write_texts(entry, "people", header.people)
    write_texts(entry, "approval", header.approval)
    if header.imported:
        write_texts(entry, IMPORTED, header.imported)
        write_verbatim(texts, MAPPING, header.mapping_text)
    if header.salvaged:
        write_texts(entry, SALVAGED, header.salvaged)
    write_values(entry, "zeros", *journal.zeros())
    write_measurements(entry, rows.rows)
    if rows.superseded:
        write_measurements(entry, rows.superseded, "superseded_measurements")
    _write_events(entry, journal.events)
    truth = new_group(entry, "verification", "NXcollection")
    for recording, values in journal.truth.items():
        name = free_name(truth, recording)
        write_values(truth, name, values, {})
        write_text(truth[name], "name", recording)


def add_recordings(entry: h5py.Group, parts: Iterable[Path], events: StoredEvents) -> None:
    """Copy the recordings out of files of their own into an entry, in order, byte by byte.

    Those whose point was repeated go into a group of their own. Each says in which part of the run
    it was made, and after how long and how many cycles since the beginning of `main`.
    """
    outline, rows = events.outline, events.measured
    repeated, part_of = superseded(outline), parts_of(outline)
    cycles = cycles_by_recording(outline)
    finished = new_group(entry, "recordings", "NXcollection")
    incomplete = new_group(entry, "incomplete", "NXcollection")
    superseded_group = new_group(entry, SUPERSEDED, "NXcollection")
    for path in parts:
        with open_file(path) as file:
            part = file[PART_GROUP]
            name = str(part.attrs["name"])
            complete = superseded_group if name in repeated else finished
            group = complete if part.attrs["complete"] else incomplete
            place = free_name(group, name)
            file.copy(part, group, place)
            group[place].attrs["part"] = part_of.get(name, 1)
            elapsed_s = seconds_since(rows.began, str(part.attrs["started_utc"]))
            if elapsed_s is not None:
                group[place].attrs["elapsed_s"] = elapsed_s
            if name in cycles:
                group[place].attrs["cycles"] = cycles[name]
    recordings = _in_order(finished)
    entry.attrs["sha256"] = _digest(recordings, events, format_of(entry))
    # What a NeXus viewer opens by itself.
    for first in recordings[:1]:
        finished.attrs["default"] = str(first.name).rpartition("/")[2]
        entry.attrs["default"] = "recordings"


def write_analysis(
    entry: h5py.Group, document: Mapping[str, Any] | None, plot: RunPlot | None
) -> None:
    """Write the first analysis: its document verbatim, and what a viewer plots first."""
    if document is None:
        return
    group = new_group(entry, "analysis", "NXprocess")
    write_verbatim(group, "result", json.dumps(document, ensure_ascii=False))
    if plot is None:
        return
    data = new_group(group, plot.name, "NXdata")
    for name, column in plot.columns.items():
        dataset = data.create_dataset(name, data=np.asarray(column.values, "<f8"))
        dataset.attrs.update({"units": column.unit, "long_name": column.long_name})
    data.attrs.update({"title": plot.title, "signal": plot.signal, "axes": [plot.axis]})
    if plot.beside:
        data.attrs["auxiliary_signals"] = list(plot.beside)
    group.attrs["default"], entry.attrs["default"] = plot.name, "analysis"


def read_entry_info(entry: h5py.Group, path: Path) -> RunInfo:
    """Read what is known without the samples."""
    return _read_info(entry, path, read_events(entry, keep=False))


def _read_info(entry: h5py.Group, path: Path, events: StoredEvents) -> RunInfo:
    texts = {name: read_text(entry, name) for name in HEADER_TEXTS}
    verbatim = {name: read_text(entry["texts"], name) for name in VERBATIM}
    provenance = read_texts(entry["provenance"])
    define_units_of(provenance, texts["run_id"])
    recordings = _in_order(entry["recordings"])
    header = RunHeader(
        **texts,
        **verbatim,
        plan_text=read_long(entry["texts"], PLAN),
        files={},
        called_texts=read_texts(entry["texts"][CALLED]) if CALLED in entry["texts"] else {},
        inputs=read_texts(entry["inputs"]),
        provenance=provenance,
        people=_read_texts(entry, "people"),
        approval=_read_texts(entry, "approval") or dict(DRAFT),
        imported=_read_texts(entry, IMPORTED),
        salvaged=_read_texts(entry, SALVAGED),
        mapping_text=read_text(entry["texts"], MAPPING) if MAPPING in entry["texts"] else "",
    )
    digest = _digest(recordings, events, format_of(entry))
    if digest != entry.attrs["sha256"]:
        raise DataError(
            f"{path}: the recordings are not those that were sealed: the SHA-256 over all differs"
        )
    return RunInfo(
        path=path,
        sealed=True,
        header=header,
        **{name: read_text(entry, name) for name in _END_TEXTS},
        recording_names=tuple(str(group.attrs["name"]) for group in recordings),
        digest=digest,
        format=format_of(entry),
        manifest_sha256=manifest_sha256(entry),
    )


def read_entry(entry: h5py.Group, path: Path) -> StoredRun:
    """Read a run whole, and the partner runs that are embedded in it."""
    events = read_events(entry)
    groups = {kind: _in_order(entry[kind]) if kind in entry else [] for kind in KINDS}
    scratch = None if sum(map(stored_bytes, groups.values())) <= IN_MEMORY else Scratch()
    measured = events.measured

    def recordings_of(kind: str) -> tuple[Recording, ...]:
        recordings = (read_recording(group, scratch)[1] for group in groups[kind])
        return with_elapsed(recordings, events.outline, measured.began)

    return StoredRun(
        info=_read_info(entry, path, events),
        recordings=recordings_of("recordings"),
        incomplete=recordings_of("incomplete"),
        superseded=recordings_of(SUPERSEDED),
        zeros=read_values(entry["zeros"])[0],
        recording_zeros=zeros_in_force(events.outline),
        measurements=measured.rows,
        superseded_measurements=measured.superseded,
        events=events,
        outline=events.outline,
        result_document=(
            json.loads(read_text(entry["analysis"], "result")) if "analysis" in entry else None
        ),
        partners={
            partner_name(entry, place): read_entry(entry[place], path)
            for place in partner_places(entry)
        },
    )


def partner_places(entry: h5py.Group) -> list[str]:
    """Return the places of the runs that are embedded in an entry, in order."""
    return [name for name in members(entry) if entry[name].attrs.get("NX_class") == PARTNER]


def partner_name(entry: h5py.Group, place: str) -> str:
    """Return the name of an embedded run; in runs of earlier versions it is its place."""
    return str(entry[place].attrs.get("name", place))


def read_entry_truth(entry: h5py.Group) -> dict[str, dict[str, float]]:
    """Read what a simulator knew, by recording."""
    groups = entry["verification"].values()
    return {read_text(group, "name"): read_values(group)[0] for group in groups}


def _write_events(entry: h5py.Group, events: StoredEvents) -> None:
    group = new_group(entry, "events", "NXcollection")
    numbers, times = array("q"), array("d")
    columns = {name: AsciiColumn() for name in ("utc", "kind", "step", "text", "json")}
    remaining = iter(events)
    while piece := [*islice(remaining, _PIECE)]:
        numbers.extend(event.seq for event in piece)
        times.extend(event.monotonic_s for event in piece)
        columns["utc"].add(event.utc for event in piece)
        columns["kind"].add(type(event).__name__ for event in piece)
        columns["step"].add(getattr(event, "step", "") for event in piece)
        columns["text"].add(getattr(event, "text", "") for event in piece)
        columns["json"].add(event_text(event) for event in piece)
    group.create_dataset("seq", data=np.asarray(numbers))
    group.create_dataset("monotonic_s", data=np.asarray(times)).attrs["units"] = "s"
    for name, column in columns.items():
        column.write(group, name)


def read_events(entry: h5py.Group, *, keep: bool = True) -> StoredEvents:
    """Read all events of a run, in order; without `keep` they are only checked."""
    events = StoredEvents(passed=None if keep else format_of(entry))
    for piece in pieces_of(entry["events/json"]):
        for text in piece:
            events.take(Kind.EVENT, bytes(text))
    return events


def _read_texts(entry: h5py.Group, name: str) -> dict[str, str]:
    """Read a table that runs of earlier versions do not have; they read as empty."""
    return read_texts(entry[name]) if name in entry else {}


def _in_order(group: h5py.Group) -> list[h5py.Group]:
    return sorted(group.values(), key=lambda recording: int(recording.attrs["number"]))


def digest_of(entry: h5py.Group, events: StoredEvents) -> str:
    """Return the digest of what an entry holds: its finished recordings and the measurements."""
    return _digest(_in_order(entry["recordings"]), events, format_of(entry))


def _digest(recordings: list[h5py.Group], events: StoredEvents, version: int) -> str:
    digests = (str(group.attrs["sha256"]) for group in recordings)
    return run_digest(digests, events.row_digests(version))
