"""Many byte strings that are alike, in memory: compressed, some at a time."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

_FASTEST = 1
_strings_from = msgspec.msgpack.Decoder(list[bytes]).decode


class Compressed:
    """Byte strings in the order in which they were added."""

    def __init__(self) -> None:
        self._pieces: list[bytes] = []
        self._count = 0

    def add(self, strings: Sequence[bytes]) -> None:
        """Add some, which are compressed together."""
        self._pieces.append(zlib.compress(msgspec.msgpack.encode(strings), _FASTEST))
        self._count += len(strings)

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[bytes]:
        for piece in self._pieces:
            yield from _strings_from(zlib.decompress(piece))
