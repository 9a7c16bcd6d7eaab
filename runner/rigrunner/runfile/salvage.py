"""Salvage the intact parts of a damaged `run.h5` into a new file that lists what is lost.

A recording is intact if its own SHA-256 is right and nothing in it differs from the manifest. The
damaged file is only read. If the file's own table of contents is damaged, nothing can be salvaged.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

import h5py

from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import UNREADABLE, members, open_file
from rigrunner.runfile.codec import check_format
from rigrunner.runfile.compressed import LongText
from rigrunner.runfile.entry import (
    FORMAT_ATTRIBUTE,
    HEADER_TEXTS,
    KINDS,
    PARTNER,
    PLAN,
    VERBATIM,
    digest_of,
    read_entry_truth,
    read_events,
    write_entry,
)
from rigrunner.runfile.hdf5 import new_file, new_group, read_text, read_texts
from rigrunner.runfile.loose import Journal
from rigrunner.runfile.manifest import (
    ENTRY_ITEM,
    MANIFEST,
    ROOT,
    Difference,
    item_of,
    kind_of,
    mismatch,
    stored_items,
    write_manifest,
)
from rigrunner.runfile.model import DRAFT, RunHeader
from rigrunner.runfile.probe import refuse_crashing
from rigrunner.runfile.reading import ENTRY, FIRST_WITH_MANIFEST
from rigrunner.runfile.recordings import read_recording, stored_bytes
from rigrunner.runfile.scratch import Scratch
from rigrunner.runfile.stored_events import StoredEvents
from rigrunner.runfile.stored_samples import IN_MEMORY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.events import Event

_T = TypeVar("_T")
EVENTS, CALLED_PLACE = "events", "texts/called"
_TEXTS = ("inputs", "provenance", "people", "approval", "imported")


@dataclass(frozen=True, kw_only=True)
class DamagedRun:
    """The readable content of a damaged sealed run."""

    path: Path
    """The damaged `run.h5`."""
    sha256: str
    """SHA-256 of its bytes."""
    header: RunHeader
    """The header, with empty texts for those that are lost."""
    events: Sequence[Event]
    """The events; empty if they are lost."""
    truth: Mapping[str, Mapping[str, float]]
    sound: Mapping[str, str]
    """The name of each intact recording by its path, such as 'recordings/_001_1Hz'."""
    partners: tuple[str, ...]
    """The paths of the embedded partner runs that are completely intact."""
    lost: tuple[Difference, ...]
    """What cannot be read, or was changed after sealing."""

    @property
    def recordings(self) -> tuple[str, ...]:
        """The names of the intact recordings of all kinds."""
        return tuple(self.sound.values())


def read_damaged(path: Path) -> DamagedRun:
    """Read the intact parts of a `run.h5`; raise DataError if nothing is found in it.

    Of an intact file nothing is lost.
    """
    refuse_crashing(path)
    with path.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    with open_file(path) as file:
        check_format(int(file.attrs[FORMAT_ATTRIBUTE]), str(path))
        return _Reader(file[ENTRY]).run(path, sha256)


def write_salvaged(
    damaged: DamagedRun, header: RunHeader, events: Sequence[Event], target: Path
) -> None:
    """Write the intact parts to a new `run.h5`, with this header and these events.

    Its recordings are those of the damaged file, byte by byte. The first analysis is left out,
    since it was made of all recordings. Raises DataError if the file cannot be written.
    """
    with open_file(damaged.path) as source, new_file(target, read_only=True) as file:
        version = max(int(source.attrs[FORMAT_ATTRIBUTE]), FIRST_WITH_MANIFEST)
        journal = Journal(header, StoredEvents(events), damaged.truth, (), 0, format=version)
        file.attrs.update({"NX_class": "NXroot", "default": ENTRY, FORMAT_ATTRIBUTE: version})
        entry = new_group(file, ENTRY, "NXentry")
        write_entry(entry, journal)
        for kind in KINDS:
            new_group(entry, kind, "NXcollection")
        for place in damaged.sound:
            source.copy(source[ENTRY][place], entry[place.partition("/")[0]])
        for place in damaged.partners:
            source.copy(source[ENTRY][place], entry)
        entry.attrs["sha256"] = digest_of(entry, journal.events)
        write_manifest(entry)


@dataclass(eq=False)
class _Reader:
    """Reads an entry part by part, and notes what is lost."""

    entry: h5py.Group
    lost: dict[str, Difference] = field(default_factory=dict)

    def run(self, path: Path, sha256: str) -> DamagedRun:
        expected = self._manifest()
        containers = {ROOT: self.entry.file, ENTRY_ITEM: self.entry}
        for place, stored in expected.items():
            try:
                item = containers[place] if place in containers else self.entry[place]
                h5py.h5o.get_info(item.id)  # reads all of its header, which attributes alone do not
                problem = mismatch(item_of(place, item), stored)
            except (DataError, *UNREADABLE) as error:
                problem = f"cannot be read, it is damaged: {error}"
            if problem:
                self._note_lost(place, problem)
        sound = dict(self._sound_recordings(expected))
        events = self._part(EVENTS, lambda: read_events(self.entry), StoredEvents())
        return DamagedRun(
            path=path,
            sha256=sha256,
            header=self._header(path),
            events=events,
            truth=self._part("verification", lambda: read_entry_truth(self.entry), {}),
            sound=sound,
            partners=tuple(filter(self._is_sound_partner, self._partners())),
            lost=tuple(sorted(self.lost.values())),
        )

    def _manifest(self) -> Mapping[str, object]:
        """Return the content of the manifest; nothing if it is damaged, or the format has none."""
        if int(self.entry.file.attrs[FORMAT_ATTRIBUTE]) < FIRST_WITH_MANIFEST:
            return {}
        try:
            return stored_items(self.entry)
        except (DataError, *UNREADABLE) as error:
            message = "cannot be read: only recordings can be checked, by digests of their own"
            self._note_lost(MANIFEST, f"{message} ({error})")
            return {}

    def _sound_recordings(self, expected: Mapping[str, object]) -> Iterator[tuple[str, str]]:
        for kind in KINDS:
            for member in self._members(kind, expected):
                place = f"{kind}/{member}"
                # Without a manifest a recording has only its own digest to be checked by.
                if (not expected or place in expected) and not self._is_lost(place):
                    try:
                        name = self._read(place)
                    except (DataError, *UNREADABLE) as error:
                        self._note_lost(place, f"cannot be read, it is damaged: {error}")
                    else:
                        yield place, name

    def _members(self, kind: str, expected: Iterable[str]) -> list[str]:
        """Return the paths of recordings of a kind, from the file or else from its manifest."""
        from_manifest = {place.split("/")[1] for place in expected if place.startswith(f"{kind}/")}
        try:
            from_file = set(members(self.entry[kind])) if kind in self.entry else set()
        except (DataError, *UNREADABLE) as error:
            self._note_lost(kind, f"cannot be listed, it is damaged: {error}")
            from_file = set()
        return sorted(from_manifest | from_file)

    def _read(self, place: str) -> str:
        """Read a recording and return its name; raise if it differs from its digest."""
        group = self.entry[place]
        small = stored_bytes([group]) <= IN_MEMORY
        return read_recording(group, None if small else Scratch())[0].name

    def _header(self, path: Path) -> RunHeader:
        texts = {name: self._text(self.entry, name) for name in HEADER_TEXTS}
        fields: dict[str, Any] = {
            **texts,
            **{name: self._verbatim(f"texts/{name}") for name in VERBATIM},
            **{name: self._named_texts(name) for name in _TEXTS},
        }
        fields["run_id"] = texts["run_id"] or path.parent.name
        fields["approval"] = fields["approval"] or dict(DRAFT)
        return RunHeader(
            **fields,
            plan_text=LongText.of(self._verbatim(f"texts/{PLAN}")),
            called_texts=self._named_texts(CALLED_PLACE),
            mapping_text=self._verbatim("texts/mapping_text"),
        )

    def _named_texts(self, place: str) -> dict[str, str]:
        """Return a group of named texts; an empty one if it is absent or lost."""

        def read() -> dict[str, str]:
            return read_texts(self.entry[place]) if place in self.entry else {}

        return self._part(place, read, dict[str, str]())

    def _text(self, group: h5py.Group, name: str) -> str:
        try:
            return read_text(group, name)
        except (DataError, *UNREADABLE) as error:
            self._note_lost(ENTRY_ITEM, f"its {name} cannot be read: {error}")
            return ""

    def _verbatim(self, place: str) -> str:
        group, _, name = place.partition("/")

        def read() -> str:
            is_stored = place in self.entry
            return read_text(self.entry[group], name) if is_stored else ""

        return self._part(place, read, "")

    def _partners(self) -> list[str]:
        """Return the paths of the embedded runs, as far as they can be found."""

        def is_partner(place: str) -> bool:
            return bool(self.entry[place].attrs.get("NX_class") == PARTNER)

        try:
            places = members(self.entry)
        except (DataError, *UNREADABLE) as error:
            self._note_lost(ENTRY_ITEM, f"its members cannot be listed: {error}")
            return []
        return [p for p in places if self._part(p, partial(is_partner, p), instead=False)]

    def _is_sound_partner(self, place: str) -> bool:
        """Return whether an embedded run is intact; without a manifest that is unknown."""

        def check() -> bool:
            for kind in KINDS:
                group = self.entry[place]
                for name in members(group[kind]) if kind in group else ():
                    self._read(f"{place}/{kind}/{name}")
            return True

        return self._part(place, check, instead=False)

    def _part(self, place: str, read: Callable[[], _T], instead: _T) -> _T:
        """Return the value of a part; note the part as lost if reading fails, or it was changed."""
        if self._is_lost(place):
            return instead
        try:
            return read()
        except (DataError, *UNREADABLE) as error:
            self._note_lost(place, f"cannot be read, it is damaged: {error}")
            return instead

    def _is_lost(self, place: str) -> bool:
        return any(lost == place or lost.startswith(f"{place}/") for lost in self.lost)

    def _note_lost(self, place: str, what: str) -> None:
        self.lost.setdefault(place, Difference(place, kind_of(place), what))
