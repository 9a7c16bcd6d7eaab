"""Procedures and stations to choose from: the laboratory's own files and the shipped ones."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from rigrunner.api.errors import RigrunnerError
from rigrunner.procedure import load_procedure
from rigrunner.run.approval import approval_state
from rigrunner.run.locate import shipped_folder
from rigrunner.station import load_station
from rigrunner_panel.errors import not_found

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

_KIND = re.compile(r"^rigrunner:\s*[\"']?(procedure|station)/", re.MULTILINE)
_HEAD_BYTES = 16_384
_FOLDERS = (".", "procedures", "stations", "procedures/stations")

What = Literal["procedure", "station"]


@dataclass(frozen=True)
class Entry:
    """A file to choose."""

    name: str
    path: Path
    id: str
    title: str
    shipped: bool
    problem: str = ""
    """Why the file cannot be used; empty if it can."""
    note: str = ""
    """For a procedure: its revision and approval."""
    changed_ns: int = 0
    """Modification time of the file when it was read, in ns."""


class Catalogue:
    """The files in a laboratory's folder and the shipped ones, by the names shown in the lists."""

    def __init__(self, folder: Path, stations: tuple[str, ...] = ()) -> None:
        self._folder = folder
        self._stations = stations
        """Those that may be used; all of them where none is named."""

    def entries(self, what: What) -> list[Entry]:
        """Return all entries, the laboratory's own first, each group sorted by name."""
        entries: dict[Path, Entry] = {}
        for path, name, shipped in self._files():
            if path.resolve() not in entries and self._is(path, name, what):
                entries[path.resolve()] = _entry(path, name, what, shipped=shipped)
        return sorted(entries.values(), key=lambda entry: (entry.shipped, entry.name))

    def path(self, what: What, name: str) -> Path:
        """Return the path of a procedure by its listed name; raise PanelError."""
        return self._file(what, name)[0]

    def station(self, name: str) -> Entry:
        """Return the entry of a station by its listed name; raise PanelError."""
        path, shipped = self._file("station", name)
        return _entry(path, name, "station", shipped=shipped)

    def _file(self, what: What, name: str) -> tuple[Path, bool]:
        for path, listed_name, shipped in self._files():
            if listed_name == name and self._is(path, name, what):
                return path, shipped
        raise not_found(f"there is no {what} '{name[:80]}'", f"see GET /api/v1/{what}s")

    def reread(self, entry: Entry) -> Entry:
        """Return a station's entry, read again from its file."""
        if _changed_ns(entry.path) == entry.changed_ns:
            return entry
        return _entry(entry.path, entry.name, "station", shipped=entry.shipped)

    def rigs(self) -> list[str]:
        """Return the names of the panel's own stations: the named ones, or the laboratory's."""
        if self._stations:
            return list(self._stations)
        names = {
            path.resolve(): name
            for path, name, shipped in self._files()
            if not shipped and self._is(path, name, "station")
        }
        return sorted(names.values())

    def _is(self, path: Path, name: str, what: What) -> bool:
        if what == "station" and self._stations and name not in self._stations:
            return False
        return _kind(path) == what

    def _files(self) -> Iterator[tuple[Path, str, bool]]:
        for subfolder in _FOLDERS:
            for path in sorted((self._folder / subfolder).glob("*.y*ml")):
                yield path, path.relative_to(self._folder).as_posix(), False
        for folder in (shipped_folder(), shipped_folder() / "stations"):
            for path in sorted(folder.glob("*.yaml")):
                yield path, path.stem, True


def kind_of(content: bytes) -> str:
    """Return the kind that a file's content declares; empty for any other content."""
    match = _KIND.search(content[:_HEAD_BYTES].decode("utf-8", "replace"))
    return match[1] if match else ""


def _kind(path: Path) -> str:
    try:
        if not path.is_file():  # opening a pipe would wait for who writes to it
            return ""
        with path.open("rb") as file:
            return kind_of(file.read(_HEAD_BYTES))
    except OSError:
        return ""


def _changed_ns(path: Path) -> int:
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def _entry(path: Path, name: str, what: What, *, shipped: bool) -> Entry:
    changed_ns = _changed_ns(path)
    try:
        if what == "procedure":
            procedure = load_procedure(path)
            model, state = procedure.model, approval_state(procedure)
            note = f"revision {model.revision}, {state.sentence()}"
            return Entry(name, path, model.id, model.title, shipped, note=note)
        station = load_station(path).model
        return Entry(name, path, station.id, station.title, shipped, changed_ns=changed_ns)
    except RigrunnerError as error:
        problem = str(error)
        return Entry(name, path, path.stem, "", shipped, problem=problem, changed_ns=changed_ns)
