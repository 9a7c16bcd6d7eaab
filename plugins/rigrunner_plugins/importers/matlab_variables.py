"""The variables of a MATLAB file as one tree, whichever version wrote it."""

from __future__ import annotations

import struct
import warnings
import zlib
from contextlib import contextmanager
from math import prod
from typing import TYPE_CHECKING, Any, Protocol

import h5py
import numpy as np
from scipy.io import loadmat, whosmat

from rigrunner.api import DataError, Location
from rigrunner_plugins.importers.hdf5_file import has_damaged_chunk, names_in

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

_HDF5_AT = 512
"""Version 7.3 has a header of this many bytes before its HDF5."""
_HDF5_BEGINS = b"\x89HDF\r\n\x1a\n"
_WORDS = {
    "struct": "a structure",
    "cell": "a cell array",
    "char": "text",
    "function_handle": "a function handle",
    "function": "a function handle",
    "sparse": "a sparse matrix",
    "opaque": "an object",
}
_MATRIX, _COMPRESSED = 14, 15
_TYPES = {*range(1, 8), 9, *range(12, 19)}
"""Those of the data elements of version 5 (MAT-File Format, table 1-1)."""
_BEGINS, _ORDER = 128, slice(126, 128)
_MOST_BYTES = 2**30
"""The most bytes of a packed variable that are checked."""
_LIST_CLASSES = {1, 2, 3}
"""Of cells, structures and objects."""
_AT_DIMENSIONS = 24
"""Where the dimensions of an array are, after its flags (16 bytes) and their own tag (8 bytes)."""
_FEW = 10_000
"""Elements of a list that are read in no time: structures without fields take no bytes."""
_LISTS = {"struct": np.dtype([("field", object)]), "cell": np.dtype(object)}
"""By class of a variable, the type of an array of such."""
_COMPLEX = "complex"
_INTEGERS = (f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
_NUMERIC = {"double", "single", "logical", *_INTEGERS}


class Node(Protocol):
    """A variable, a field, or the file itself."""

    @property
    def kind(self) -> str:
        """'numbers', or in words what it is instead."""
        ...

    def names(self) -> Sequence[str]:
        """Return the names of its members; none where it is no structure."""
        ...

    def member(self, name: str) -> Node:
        """Return a member."""
        ...

    def array(self) -> NDArray[np.generic]:
        """Return its numbers as MATLAB shows them: rows by columns."""
        ...


@contextmanager
def open_variables(path: Path) -> Iterator[Node]:
    """Give the variables of a file; each is read on request only."""
    with path.open("rb") as file:
        file.seek(_HDF5_AT)
        is_hdf5 = file.read(len(_HDF5_BEGINS)) == _HDF5_BEGINS
    if is_hdf5:
        with h5py.File(path, "r") as hdf5:
            yield _Hdf5Node(hdf5)
        return
    _refuse_damaged(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of scipy, on variables that are not requested
        yield _File5(path)


def _refuse_damaged(path: Path) -> None:
    """Raise DataError for data elements on which scipy can crash, or read without end."""
    content = path.read_bytes()
    if 0 in content[:4]:  # of version 4, which has no such elements
        return
    order = "<" if content[_ORDER] == b"IM" else ">"
    try:
        damage = _damage(memoryview(content)[_BEGINS:], order)
    except (zlib.error, RecursionError, struct.error) as error:
        raise DataError(
            "is not a MATLAB file, or is damaged", location=Location(str(path))
        ) from error
    if damage:
        raise DataError(
            f"is not a MATLAB file, or is damaged: {damage}", location=Location(str(path))
        )


def _damage(data: memoryview | bytes, order: str, *, nested: bool = False) -> str:
    """Return what is wrong with the first damaged data element, at any depth; '' for nothing.

    The data of a list that is not `nested` are not read.
    """
    position = 0
    while position + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, position)
        begins = position + 8
        if kind >> 16:  # a small element: size and type in four bytes, and the data in four
            kind, size, begins = kind & 0xFFFF, 4, position + 4
        if kind not in _TYPES:
            return f"it has an element of the type {kind}"
        inner = data[begins : begins + size]
        if kind == _COMPRESSED:
            inner = zlib.decompressobj().decompress(inner, _MOST_BYTES)
        if kind == _MATRIX and nested and (count := _count(inner, order)) > len(inner) // 8 + _FEW:
            return f"a list in it has {count} elements in {len(inner)} bytes"
        if kind in {_MATRIX, _COMPRESSED}:
            damage = _damage(inner, order, nested=kind == _MATRIX)
            if damage:
                return damage
        position = begins + size
        # All elements but packed ones are filled up to a multiple of 8 bytes.
        position += 0 if kind == _COMPRESSED else -position % 8
    return ""


def _count(matrix: memoryview | bytes, order: str) -> int:
    """Return how many elements a list of cells or structures has; 0 for numbers.

    Each has a tag of 8 bytes. The first two data elements of an array are its class, and its
    dimensions, as MAT-File Format, table 1-3, has them.
    """
    if len(matrix) < _AT_DIMENSIONS or matrix[8 if order == "<" else 11] not in _LIST_CLASSES:
        return 0
    size = struct.unpack_from(f"{order}I", matrix, _AT_DIMENSIONS - 4)[0]
    sizes = struct.unpack_from(f"{order}{size // 4}I", matrix, _AT_DIMENSIONS)
    return prod(sizes)


class _File5:
    """A file of version 5 to 7."""

    kind = "a file"

    def __init__(self, path: Path) -> None:
        self._path = path
        table = whosmat(path)
        names = [name for name, _, _ in table]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise DataError(f"the variable '{twice}' is given twice", location=Location(str(path)))
        self._names = names
        self._lists = {
            name: _LISTS[kind] for name, shape, kind in table if kind in _LISTS and prod(shape) > 1
        }

    def names(self) -> Sequence[str]:
        return self._names

    def member(self, name: str) -> Node:
        if name in self._lists:
            # None of its elements can be a column, and a damaged shape could make it endless.
            return _Value5(np.empty(0, self._lists[name]))
        return _Value5(loadmat(self._path, variable_names=[name], struct_as_record=True)[name])

    def array(self) -> NDArray[np.generic]:
        raise AssertionError


class _Value5:
    """A value out of such a file."""

    def __init__(self, value: Any) -> None:
        self._value = value

    @property
    def kind(self) -> str:
        value = self._value
        if not isinstance(value, np.ndarray):
            return _WORDS["sparse"] if hasattr(value, "tocsc") else "no array"
        if value.dtype.names:
            return _WORDS["struct"] if value.size == 1 else "a list of structures"
        kinds = {"O": "cell", "U": "char", "S": "char"}
        if value.dtype.kind in kinds:
            return _WORDS[kinds[value.dtype.kind]]
        return _COMPLEX if value.dtype.kind == "c" else "numbers"

    def names(self) -> Sequence[str]:
        single = isinstance(self._value, np.ndarray) and self._value.size == 1
        return (self._value.dtype.names or ()) if single else ()

    def member(self, name: str) -> Node:
        return _Value5(self._value[name].flat[0])

    def array(self) -> NDArray[np.generic]:
        return np.asarray(self._value)


class _Hdf5Node:
    """A group or dataset of a file of version 7.3."""

    def __init__(self, node: Any) -> None:
        self._node = node

    @property
    def kind(self) -> str:
        raw = self._node.attrs.get("MATLAB_class", b"")
        name = raw.decode("ascii", "replace") if isinstance(raw, bytes) else str(raw)
        if isinstance(self._node, h5py.Group):
            return _WORDS["struct"]
        if "MATLAB_sparse" in self._node.attrs:
            return _WORDS["sparse"]
        if name in _NUMERIC or (not name and self._node.dtype.kind in "iuf"):
            return _COMPLEX if self._node.dtype.names else "numbers"
        return _WORDS.get(name, f"of the class '{name}'" if name else "no array")

    def names(self) -> Sequence[str]:
        if not isinstance(self._node, h5py.Group):
            return ()
        # MATLAB's own groups are #refs# and #subsystem#.
        return [name for name in names_in(self._node) if not name.startswith("#")]

    def member(self, name: str) -> Node:
        node = self._node[name]
        if node.file.filename != self._node.file.filename:
            raise DataError(f"'{name}' is kept in another file")
        return _Hdf5Node(node)

    def array(self) -> NDArray[np.generic]:
        if self._node.attrs.get("MATLAB_empty", 0):
            return np.empty((0, 0))
        if self._node.is_virtual or self._node.external:
            raise DataError(f"'{self._node.name}' is kept in another file")
        if has_damaged_chunk(self._node):
            raise DataError(f"'{self._node.name}' is damaged")
        # MATLAB writes column by column, which HDF5 shows as rows.
        return np.asarray(self._node[...]).T
