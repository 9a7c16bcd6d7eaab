"""An append-only file of records, each with its length and checksum.

Records that were appended before the writer died are read back; reading stops at a torn or damaged
record.
"""

from __future__ import annotations

import os
import struct
from contextlib import suppress
from enum import IntEnum
from time import monotonic
from typing import TYPE_CHECKING, BinaryIO, NamedTuple
from zlib import crc32

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

MAGIC = b"RIGJ\x01\r\n\x00"
"""Byte 4 is the version of the framing."""
_HEAD = struct.Struct("<IBI")
"""Length of the payload, kind, CRC-32 over both and the payload."""
_SYNC_EVERY_S = 1.0
_SMALL = 4096
"""Parts up to this many bytes are copied after their head; larger ones are written separately."""


class Kind(IntEnum):
    """The content of a record."""

    HEADER = 1
    EVENT = 2
    """An event as JSON."""
    TRUTH = 3
    BLOCK = 4
    ROW = 5
    """A point of a scan as numbers alone; read, but no longer written."""
    PACKED = 6
    """An event as MessagePack."""
    PLAN = 7
    """A part of the text of the plan, before the header; see `LongText`. Earlier versions wrote it
    into the header."""


class Record(NamedTuple):
    """One intact record; `end` is where the next one begins in the file."""

    kind: int
    payload: bytes
    end: int


class JournalWriter:
    """Appends records. An incomplete record is removed again; raises OSError."""

    def __init__(self, path: Path, records_end: int | None = None) -> None:
        """Create a journal, or continue one whose last intact record ends at `records_end`.

        Anything after that record is cut off: records behind it could not be read.
        """
        self.path = path
        self.sync_due_s = monotonic() + _SYNC_EVERY_S
        """When the latest records are to be synced."""
        # "x": a journal is never written over.
        self._file = path.open("xb" if records_end is None else "r+b", buffering=0)
        self._end = len(MAGIC) if records_end is None else records_end
        try:
            if records_end is None:
                self._write(MAGIC)
            else:
                self._file.truncate(records_end)
                self._file.seek(records_end)
        except BaseException:
            self._file.close()
            raise

    def append(self, kind: Kind, *parts: bytes | memoryview) -> None:
        """Append one record whose payload is the parts in order; the system has it on return.

        A short one is one write; the parts of a long one are not copied.
        """
        length = sum(map(len, parts))
        record = (_HEAD.pack(length, kind, _checksum(length, kind, parts)), *parts)
        try:
            for part in record if length > _SMALL else (b"".join(record),):
                self._write(part)
        except BaseException:  # also Ctrl-C: what follows a torn record would be lost
            with suppress(OSError):
                self._file.seek(self._end)
                self._file.truncate()
            raise
        self._end += _HEAD.size + length

    def sync(self) -> None:
        """Wait until everything is on the disk; raise FileNotFoundError if the file has no name.

        What is written to a file that was deleted, or moved with its folder, would be lost.
        """
        self.path.stat()
        os.fsync(self._file.fileno())
        self.sync_due_s = monotonic() + _SYNC_EVERY_S

    def sync_sometimes(self) -> None:
        """Sync, if the last sync was a second ago or more."""
        if monotonic() > self.sync_due_s:
            self.sync()

    def close(self) -> None:
        """Close the file; idempotent."""
        self._file.close()

    def _write(self, data: bytes | memoryview) -> None:
        # Unbuffered: the system may take a part, and then says so.
        written = self._file.write(data) or 0
        while written < len(data):
            written += self._file.write(memoryview(data)[written:]) or 0


def read_records(path: Path) -> Iterator[Record]:
    """Yield the intact records up to the first torn or damaged one.

    Raises DataError if the file is no journal; a file too short for the mark has no records.
    """
    with path.open("rb") as file:
        magic = file.read(len(MAGIC))
        if magic != MAGIC[: len(magic)]:
            raise DataError(
                f"{path} is not a journal of this version of Rigrunner",
                hint="keep the folder, and restore its journal from a backup",
            )
        size = path.stat().st_size
        end = len(magic)
        while record := _next(file, end, size):
            end = record.end
            yield record


def unread_bytes(path: Path, records_end: int | None) -> int:
    """Return the number of bytes after the last intact record, which ends at `records_end`."""
    return path.stat().st_size - (len(MAGIC) if records_end is None else records_end)


def _next(file: BinaryIO, start: int, size: int) -> Record | None:
    head = file.read(_HEAD.size)
    if len(head) < _HEAD.size:
        return None
    length, kind, checksum = _HEAD.unpack(head)
    end = start + _HEAD.size + length
    # A damaged length must not ask for memory.
    if end > size:
        return None
    payload = file.read(length)
    if checksum != _checksum(length, kind, (payload,)):
        return None
    return Record(kind, payload, end)


def _checksum(length: int, kind: int, parts: Sequence[bytes | memoryview]) -> int:
    checksum = crc32(_HEAD.pack(length, kind, 0))
    for part in parts:
        checksum = crc32(part, checksum)
    return checksum
