"""Mutates the valid files of a target."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.random import Generator

TOKENS = (
    b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xc3", b"\r", b"\n", b"\t", b" ", b"-", b": ", b"[",
    b"{", b"}", b"]", b"&a ", b"*a", b"!!python/object:os.system ", b"<<: ", b"---\n", b"...\n",
    b"# ", b"'", b'"', b"|", b">", b"%", b"$x", b"${x}", b"../../etc/passwd", b"/dev/zero", b"C:\\",
    b"1e999", b"nan", b"-0", b".inf", b"0x10", b"1_000", b"010", b"10:30", b"2026-01-01", b"~",
    b"true", b"null", b"no", b"99999999999999999999999", b"1,5", b"N\xc2\xb7m", b"\xe2\x80\xae",
    b"<script>", b"\xf0\x9f\x94\xa5", b"{}", b"[]", b'""', b"1.5", b"-7",
)  # fmt: skip


def mutated(seeds: Sequence[bytes], rng: Generator) -> bytes:
    """Return one of the seeds with one to eight changes."""
    data = seeds[rng.integers(len(seeds))]
    for _ in range(rng.integers(1, 9)):
        change = CHANGES[rng.integers(len(CHANGES))]
        data = change(data, rng)
    return data


def _flip(data: bytes, rng: Generator) -> bytes:
    if not data:
        return data
    at = rng.integers(len(data))
    return data[:at] + bytes([data[at] ^ (1 << rng.integers(8))]) + data[at + 1 :]


def _byte(data: bytes, rng: Generator) -> bytes:
    if not data:
        return data
    at = rng.integers(len(data))
    return data[:at] + bytes([rng.integers(256)]) + data[at + 1 :]


def _insert(data: bytes, rng: Generator) -> bytes:
    at = rng.integers(len(data) + 1)
    return data[:at] + TOKENS[rng.integers(len(TOKENS))] * rng.integers(1, 4) + data[at:]


def _replace_word(data: bytes, rng: Generator) -> bytes:
    """Replace the text between two delimiters with a token."""
    marks = [i for i, byte in enumerate(data) if byte in b' ,:{}[]"\n']
    if len(marks) < 2:
        return _insert(data, rng)
    at = rng.integers(len(marks) - 1)
    token = TOKENS[rng.integers(len(TOKENS))]
    return data[: marks[at] + 1] + token + data[marks[at + 1] :]


def _remove(data: bytes, rng: Generator) -> bytes:
    start, length = rng.integers(len(data) + 1), rng.integers(1, 64)
    return data[:start] + data[start + length :]


def _truncate(data: bytes, rng: Generator) -> bytes:
    return data[: rng.integers(len(data) + 1)]


def _repeat(data: bytes, rng: Generator) -> bytes:
    start, length = rng.integers(len(data) + 1), rng.integers(1, 256)
    piece = data[start : start + length]
    return data[:start] + piece * rng.integers(2, 40) + data[start + length :]


def _move(data: bytes, rng: Generator) -> bytes:
    start, length = rng.integers(len(data) + 1), rng.integers(1, 128)
    piece, remaining = data[start : start + length], data[:start] + data[start + length :]
    at = rng.integers(len(remaining) + 1)
    return remaining[:at] + piece + remaining[at:]


CHANGES: tuple[Callable[[bytes, Generator], bytes], ...] = (
    _flip, _flip, _byte, _insert, _insert, _replace_word, _replace_word, _remove, _truncate,
    _repeat, _move,
)  # fmt: skip
