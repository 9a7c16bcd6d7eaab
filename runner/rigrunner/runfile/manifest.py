"""The manifest of a sealed run: the SHA-256 of every object in its file.

An object is a group with its attributes and the names of its members, or a dataset with its
attributes and values. Its digest is taken over a JSON text (keys sorted, no spaces), so that it can
be computed without this program; docs/reference/run-file.md says how.
"""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from rigrunner.api.analysis.requirements import partner_words
from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import UNREADABLE, members, objects
from rigrunner.runfile.hdf5 import write_verbatim

if TYPE_CHECKING:
    from collections.abc import Iterator

FORMAT = "rigrunner: manifest/1"
MANIFEST = "manifest"
"""The dataset of the manifest, the only object without a digest in it."""
ROOT = "/"
ENTRY_ITEM = "."
_BYTES = 1 << 20
"""How much of a dataset is in memory at once."""
_KINDS = {
    ROOT: "file",
    ENTRY_ITEM: "run",
    "analysis": "result",
    "events": "event list",
    "incomplete": "incomplete recording",
    "measurements": "measurement",
    "recordings": "recording",
    "superseded": "superseded recording",
    "superseded_measurements": "superseded measurement",
    "texts": "parameters",
    "verification": "truth",
    "zeros": "zero",
}
_TEXTS = {
    h5py.h5t.CSET_ASCII: h5py.h5t.py_create(h5py.string_dtype("ascii")),
    h5py.h5t.CSET_UTF8: h5py.h5t.py_create(h5py.string_dtype("utf-8")),
}
"""How texts are read, by their coding in the file."""
_NAMED_SO = ("approval", "imported", "inputs", "manifest", "people", "provenance", "salvaged")
_SAMPLES = ("recordings", "incomplete", "superseded")


@dataclass(frozen=True, order=True)
class Difference:
    """An object of a run file that differs from its manifest."""

    path: str
    """As in the manifest: from the entry, '.' for the entry itself, '/' for the file."""
    kind: str
    what: str
    """As text: changed, missing, added or unreadable."""

    def __str__(self) -> str:
        """Return the place in the file, the kind of object, and what is wrong with it."""
        return f"{place(self.path)} ({self.kind}): {self.what}"


def place(path: str) -> str:
    """Return the path in the file of an item of the manifest."""
    return path if path == ROOT else "/entry" if path == ENTRY_ITEM else f"/entry/{path}"


def write_manifest(entry: h5py.Group) -> None:
    """Write the manifest of all objects in the file; nothing may be written after it."""
    write_verbatim(entry, MANIFEST, manifest_text(entry))


def manifest_text(entry: h5py.Group) -> str:
    """Return the manifest as JSON in its canonical form: keys sorted, no spaces, ASCII."""
    items = {
        path: {"kind": kind_of(path), "sha256": object_digest(item, path)}
        for path, item in _items(entry)
    }
    return _canonical({"format": FORMAT, "items": items})


def manifest_sha256(entry: h5py.Group) -> str:
    """Return the SHA-256 of the stored text of the manifest; '' without one."""
    if MANIFEST not in entry:
        return ""
    return hashlib.sha256(bytes(entry[MANIFEST][()])).hexdigest()


def kind_of(path: str) -> str:
    """Return the kind of an object as text. Objects of few runs belong to a partner run."""
    top = path if path in {ROOT, ENTRY_ITEM} else path.partition("/")[0]
    return _KINDS.get(top, top if top in _NAMED_SO else partner_words(top))


def object_digest(item: h5py.Group | h5py.Dataset, path: str = "") -> str:
    """Return the SHA-256 of one object, without the content of its members; raise DataError."""
    names: list[bytes] = []
    h5py.h5a.iterate(item.id, names.append)
    document: dict[str, Any] = {
        "attributes": {name.decode(): _attribute(item, name) for name in names}
    }
    if isinstance(item, h5py.Dataset):
        document |= {
            "dtype": item.dtype.str,
            "shape": list(item.shape),
            "data": _data_digest(item, path),
        }
    else:
        # A manifest cannot have a digest of itself.
        hidden = {MANIFEST} if path == ENTRY_ITEM else set()
        document["members"] = sorted(set(members(item)) - hidden)
    return hashlib.sha256(_canonical(document).encode()).hexdigest()


def differences(entry: h5py.Group, *, samples: bool = True) -> Iterator[Difference]:
    """Yield the differences from the manifest, in the order of the file.

    Without `samples` the columns of recordings, which have a digest of their own, are skipped.
    Raises DataError if the structure of the file is too damaged to walk through.
    """
    # First: the walk refuses what no run file has, also in the manifest.
    items = {
        path: item_of(path, item) if samples or not _is_column(path, item) else None
        for path, item in _items(entry)
    }
    try:
        expected = stored_items(entry)
    except (DataError, *UNREADABLE) as error:
        yield Difference(MANIFEST, "manifest", f"cannot be read: {error}")
        return
    for path, item in items.items():
        stored = expected.pop(path, None)
        if item is not None and (problem := mismatch(item, stored)):
            yield Difference(path, kind_of(path), problem)
    for path in expected:
        yield Difference(path, kind_of(path), "missing: the manifest names it")


def item_of(path: str, item: h5py.Group | h5py.Dataset) -> dict[str, str] | str:
    """Return what the manifest is to say of an object, or why it cannot be read."""
    try:
        return {"kind": kind_of(path), "sha256": object_digest(item, path)}
    except (DataError, *UNREADABLE) as error:
        return f"cannot be read, it is damaged: {error}"


def mismatch(item: dict[str, str] | str, stored: object) -> str:
    """Return how an object differs from its entry in the manifest; '' if it does not."""
    if stored is None:
        return "added: the manifest does not name it"
    if isinstance(item, str):
        return item
    return "" if item == stored else "not what was sealed: its SHA-256 differs from the manifest"


def _items(entry: h5py.Group) -> Iterator[tuple[str, h5py.Group | h5py.Dataset]]:
    if entry.parent.name == ROOT:
        yield ROOT, entry.parent
    yield ENTRY_ITEM, entry
    for path, item in objects(entry):
        if path != MANIFEST:
            yield path, item


def stored_items(entry: h5py.Group) -> dict[str, object]:
    """Return the content of the manifest, by path; raise DataError if it is invalid."""
    if MANIFEST not in entry:
        raise DataError("there is none, although this version of the layout has one")
    text = bytes(entry[MANIFEST][()]).decode("ascii")
    document = json.loads(text)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise DataError(f"it is not of the format '{FORMAT}'")
    if text != _canonical(document) or not isinstance(document.get("items"), dict):
        raise DataError("it is not in its canonical form")
    if len(document) != 2 or len(entry[MANIFEST].attrs):  # noqa: PLR2004  (format and items)
        raise DataError("it holds more than its items")
    return dict(document["items"])


def _is_column(path: str, item: h5py.Group | h5py.Dataset) -> bool:
    """Return whether it holds samples: recordings/name/column, also of a partner run."""
    # Padded, so that a short path has three parts too.
    *_, kind, _name, _column = ("", "", *path.split("/"))
    return isinstance(item, h5py.Dataset) and kind in _SAMPLES


def _data_digest(dataset: h5py.Dataset, path: str) -> str:
    if dataset.dtype.hasobject:
        raise DataError(f"{path} is of a type that no run file has: {dataset.dtype}")
    digest = hashlib.sha256()
    if dataset.shape == ():
        digest.update(np.asarray(dataset[()]).tobytes())
    else:
        size = dataset.dtype.itemsize * math.prod(dataset.shape[1:])
        rows = max(_BYTES // max(size, 1), 1)
        for start in range(0, dataset.shape[0], rows):
            digest.update(np.ascontiguousarray(dataset[start : start + rows]).data)
    return digest.hexdigest()


def _attribute(item: h5py.Group | h5py.Dataset, name: bytes) -> object:
    """Return a text as it is; for numbers the type, shape and bytes."""
    attribute = h5py.h5a.open(item.id, name)
    kind = attribute.get_type()
    is_text = isinstance(kind, h5py.h5t.TypeStringID) and kind.is_variable_str()
    if is_text and attribute.shape == ():
        # As item.attrs[name] does, which takes twice as long for a text: most attributes are texts.
        text = np.empty((), object)
        attribute.read(text, mtype=_TEXTS[kind.get_cset()])
        return bytes(text[()]).decode("utf-8", "surrogateescape")
    array = np.asarray(item.attrs[name.decode()])
    if array.dtype.hasobject:
        return [str(text) for text in array.ravel()]
    return {"dtype": array.dtype.str, "shape": list(array.shape), "data": array.tobytes().hex()}


def _canonical(document: object) -> str:
    return json.dumps(document, sort_keys=True, separators=(",", ":"))
