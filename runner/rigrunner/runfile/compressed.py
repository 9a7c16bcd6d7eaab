"""Many byte strings that are alike, or a long text, in memory: compressed, some at a time."""

from __future__ import annotations

import zlib
from operator import eq
from typing import TYPE_CHECKING

import msgspec

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

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


PART = 1 << 18
"""Bytes of a long text that are compressed together."""


class LongText:
    """A text that may be long, as UTF-8, of which one part at a time is unpacked."""

    def __init__(self, parts: Iterable[bytes] = ()) -> None:
        """Take the text, in parts of any length."""
        self.packed: list[bytes] = []
        """Parts of PART bytes, compressed by zlib; the last one may be shorter."""
        unpacked = b""
        for part in parts:
            unpacked += part
            full = len(unpacked) - len(unpacked) % PART
            for at in range(0, full, PART):
                self.packed.append(zlib.compress(unpacked[at : at + PART], _FASTEST))
            unpacked = unpacked[full:]
        if unpacked:
            self.packed.append(zlib.compress(unpacked, _FASTEST))

    @classmethod
    def of(cls, text: str) -> LongText:
        """Return a text that is at hand."""
        return cls([text.encode(errors="surrogateescape")])

    def __iter__(self) -> Iterator[bytes]:
        """Yield its parts; raise DataError for one that is damaged."""
        return map(_unpack, self.packed)

    def __str__(self) -> str:
        return b"".join(self).decode(errors="surrogateescape")

    def __eq__(self, other: object) -> bool:
        # Unpacked: another build of zlib may pack the same text otherwise.
        if not isinstance(other, LongText) or len(self.packed) != len(other.packed):
            return False
        return all(map(eq, self, other))

    def __hash__(self) -> int:
        return hash(str(self))


def _unpack(packed: bytes) -> bytes:
    unpack = zlib.decompressobj()
    try:
        part = unpack.decompress(packed, PART)
    except zlib.error as error:
        raise DataError(f"a part of a long text is damaged: {error}") from error
    if not unpack.eof:
        raise DataError(f"a part of a long text is damaged, or longer than {PART:,} bytes")
    return part
