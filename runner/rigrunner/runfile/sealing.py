"""Seal a run: write journal and finished recordings to the final file."""

from __future__ import annotations

import shutil
from contextlib import suppress
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import open_file
from rigrunner.runfile.durable import reading, writing
from rigrunner.runfile.entry import (
    FORMAT_ATTRIBUTE,
    PARTNER,
    add_recordings,
    format_of,
    partner_places,
    write_analysis,
    write_entry,
)
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.hdf5 import free_name, new_file, new_group
from rigrunner.runfile.interrupts import uninterrupted
from rigrunner.runfile.loose import PART_GROUP, read_journal, unfolded_journals
from rigrunner.runfile.manifest import write_manifest
from rigrunner.runfile.reading import ENTRY, FIRST_WITH_MANIFEST, sealed_file_of
from rigrunner.runfile.recordings import write_recording

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    import h5py

    from rigrunner.api.details import RunPlot
    from rigrunner.api.events import Event
    from rigrunner.runfile.loose import Journal, SampleJournal

_NOT_EMBEDDED = ("verification", "analysis")


@uninterrupted()
def seal(
    folder: Path,
    result_document: Mapping[str, Any] | None = None,
    plot: RunPlot | None = None,
    partners: Mapping[str, Path] = MappingProxyType({}),
    *,
    journal: Journal | None = None,
) -> Path:
    """Make `run.h5` of a run that is over, or was killed, and return its path.

    The file appears complete, by one rename, and read-only; journal and single recordings are
    removed once it is on the disk. `partners` are the runs (file or folder), by name, with which
    the result was computed: they are embedded. `journal` is that of the folder, if it has been read
    since the run was over. Raises DataError if the run is sealed already or
    cannot be written.
    """
    files = RunFolder(folder)
    with reading(folder):
        if files.sealed_file.exists():
            raise DataError(f"{files.sealed_file} is sealed, and is never written again")
        journal = journal or read_journal(files)
        # Those that a kill interrupted, and those whose fold failed.
        for samples in unfolded_journals(files):
            fold(files, samples, journal.events.outline)
    with new_file(files.sealed_file, read_only=True) as file:
        version = max(journal.format, FIRST_WITH_MANIFEST)
        file.attrs.update({"NX_class": "NXroot", "default": ENTRY, FORMAT_ATTRIBUTE: version})
        entry = new_group(file, ENTRY, "NXentry")
        _write_loose(entry, files, journal)
        write_analysis(entry, result_document, plot)
        for name, path in partners.items():
            _embed(entry, name, path)
        write_manifest(entry)
    # Last: a kill at any instant leaves either these or the sealed file. If they cannot be removed,
    # they are harmless.
    for folder_left in (files.journal, files.parts):
        with suppress(OSError):  # it ignores most errors itself
            shutil.rmtree(folder_left, ignore_errors=True)
    return files.sealed_file


def fold(files: RunFolder, samples: SampleJournal, events: Iterable[Event]) -> None:
    """Turn a journal of samples into a durable file of its own, and remove the journal."""
    with writing(files.parts):
        files.parts.mkdir(exist_ok=True)
    with new_file(files.part(samples.number)) as file:
        group = file.create_group(PART_GROUP)
        write_recording(group, samples.facts(events), samples.blocks())
    with suppress(OSError):  # on Windows while somebody reads it; the file counts from now on
        samples.path.unlink()


def _write_loose(entry: h5py.Group, files: RunFolder, journal: Journal) -> None:
    write_entry(entry, journal)
    add_recordings(entry, files.finished_parts(), journal.events)


def _embed(entry: h5py.Group, name: str, partner: Path) -> None:
    group = new_group(entry, free_name(entry, name), PARTNER)
    group.attrs["name"] = name
    sealed = sealed_file_of(partner)
    if sealed is None:
        loose = RunFolder(partner)
        journal = replace(read_journal(loose), truth={})
        group.attrs[FORMAT_ATTRIBUTE] = journal.format
        _write_loose(group, loose, journal)
        del group["verification"]  # empty, as no truth was given
        return
    with open_file(sealed) as file:
        source = file[ENTRY]
        group.attrs.update(
            {attr: source.attrs[attr] for attr in source.attrs if attr != "NX_class"}
        )
        excluded = {*_NOT_EMBEDDED, *partner_places(source)}
        group.attrs[FORMAT_ATTRIBUTE] = format_of(source)
        for member in source:
            if member not in excluded:
                file.copy(source[member], group, member)
    group.attrs["default"] = "recordings"
