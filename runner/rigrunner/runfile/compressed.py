"""Many byte strings that are alike, in memory: compressed, some at a time."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterator

_PIECE = 1 << 18
"""Bytes that are compressed together, about as many as a piece of a column in a run file."""
_FASTEST = 1
_strings_from = msgspec.msgpack.Decoder(list[bytes]).decode


class Compressed:
    """Byte strings in the order in which they were added."""

    def __init__(self) -> None:
        self._pieces: list[bytes] = []
        self._latest: list[bytes] = []
        self._room = _PIECE
        self._count = 0

    def add(self, string: bytes) -> None:
        """Add one at the end."""
        self._latest.append(string)
        self._count += 1
        self._room -= len(string)
        if self._room <= 0:
            self._pieces.append(zlib.compress(msgspec.msgpack.encode(self._latest), _FASTEST))
            self._latest, self._room = [], _PIECE

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[bytes]:
        for piece in self._pieces:
            yield from _strings_from(zlib.decompress(piece))
        yield from self._latest
