"""One tape: a file of JSON lines, one per exchange, in the order in which they end.

A line is written by one system call, so that a tape can be read up to a crash.
"""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING, Any, BinaryIO

from rigrunner.api.errors import DataError, Location
from rigrunner.tape.codec import decode, decode_error, encode, encode_error

if TYPE_CHECKING:
    from pathlib import Path

_SEQ = re.compile(rb'\{"seq":(\d+),')


@dataclass(frozen=True)
class Entry:
    """One exchange on a tape."""

    line: int
    """Of the file, from 1."""
    request: str
    answer: Any
    error: BaseException | None
    took_s: float

    def outcome(self) -> Any:
        """Return the answer, or raise the recorded exception."""
        if self.error is not None:
            raise self.error
        return self.answer


def entry_line(seq: int, request: str, answer: Any, took_s: float) -> bytes:
    """Return the line of an exchange; its answer may be an exception.

    Raises TypeError for an answer that cannot be stored.
    """
    if isinstance(answer, BaseException):
        outcome = {"error": encode_error(answer)}
    else:
        outcome = {"answer": encode(answer)}
    entry = {"seq": seq, "ask": request, **outcome, "took_s": round(took_s, 6)}
    return json.dumps(entry, separators=(",", ":"), allow_nan=False).encode() + b"\n"


class TapeFile:
    """Reads a tape: the position of each exchange, by its number in the order of requests.

    Raises DataError for a file that cannot be read or is no tape; a missing one is empty. An
    incomplete last line is ignored.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._places: dict[int, tuple[int, int]] = {}
        self._file: BinaryIO = BytesIO()
        digest, offset = hashlib.sha256(), 0
        try:
            if path.exists():
                self._file = path.open("rb")
            for number, line in enumerate(self._file, start=1):
                digest.update(line)
                self._index(number, offset, line)
                offset += len(line)
        except OSError as error:
            raise DataError(f"cannot read the tape {path}: {error.strerror or error}") from error
        except DataError:
            self.close()
            raise
        self.sha256 = digest.hexdigest()

    def close(self) -> None:
        """Close the file; idempotent."""
        self._file.close()

    def __len__(self) -> int:
        return len(self._places)

    def line_of(self, seq: int) -> int:
        """Return the line of an exchange, or of the last one before it; 0 if there is none."""
        return next((self._places[n][0] for n in range(seq, -1, -1) if n in self._places), 0)

    def entry(self, seq: int) -> Entry | None:
        """Return the exchange of that number; None where the tape has none."""
        if seq not in self._places:
            return None
        number, offset = self._places[seq]
        self._file.seek(offset)
        try:
            stored = json.loads(self._file.readline())
            error = decode_error(stored["error"]) if "error" in stored else None
            answer = None if error is not None else decode(stored["answer"])
            return Entry(number, str(stored["ask"]), answer, error, float(stored["took_s"]))
        except (
            ValueError, TypeError, KeyError, AttributeError, RecursionError, DataError,
        ) as cause:  # fmt: skip
            raise DataError(f"not an exchange: {cause}", location=self.place(number)) from cause

    def place(self, line: int) -> Location:
        """Return a line of the file."""
        return Location(str(self.path), line)

    def _index(self, number: int, offset: int, line: bytes) -> None:
        if not line.endswith(b"\n"):
            return  # torn by a crash
        # Only the number: answers can be large, and are decoded when they are requested.
        match = _SEQ.match(line)
        if match is None:
            hint = "a tape is written by --record, and not to be edited"
            raise DataError("not an exchange", location=self.place(number), hint=hint)
        seq = int(match[1])
        if seq in self._places:
            raise DataError(f"exchange {seq} comes twice", location=self.place(number))
        self._places[seq] = (number, offset)
