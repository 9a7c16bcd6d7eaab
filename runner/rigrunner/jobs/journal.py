"""Finished items on disk, one line each, from which interrupted work is resumed."""

from __future__ import annotations

import errno
import json
import os
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, BinaryIO

from filelock import FileLock, Timeout

from rigrunner.api.errors import DataError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

FORMAT = "rigrunner: done/1"
_START = json.dumps({"format": FORMAT}).encode().removesuffix(b"}")
"""The start of the first line of each journal."""


class Journal:
    """The values of finished items by their keys. JSON must be able to hold a value."""

    def __init__(self, path: Path, file: BinaryIO, values: dict[str, Any]) -> None:
        self.path = path
        self._file = file
        self._values = values

    def __len__(self) -> int:
        """Return how many items are finished."""
        return len(self._values)

    def __contains__(self, key: str) -> bool:
        """Return whether an item is finished."""
        return key in self._values

    def __getitem__(self, key: str) -> Any:
        """Return the value of an item."""
        return self._values[key]

    def add(self, key: str, value: Any) -> None:
        """Store the value of an item; raise DataError if it cannot be written."""
        with _writing(self.path):
            _append(self._file, [key, value])
        self._values[key] = value


@contextmanager
def journal(path: Path, task: Mapping[str, str]) -> Iterator[Journal]:
    """Open or create the journal of a task, described by `task`.

    The file has JSON lines, the first of which describes the task. Only complete lines count, so
    the process may be killed at any time. Raises UsageError if the file belongs to another task or
    is in use, and DataError if it is damaged or cannot be written.
    """
    lock = FileLock(path.with_name(f"{path.name}.lock"), timeout=0)
    with _writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            lock.acquire()
        except Timeout as error:  # it is an OSError as well
            raise UsageError(
                f"{path} is in use by another process", hint="wait for its end, or stop it"
            ) from error
    try:
        with _writing(path):
            file = path.open("a+b", buffering=0)
        with file:
            yield Journal(path, file, _read(path, file, dict(task)))
    finally:
        lock.release()


def discard(path: Path) -> None:
    """Remove a journal that is no longer needed."""
    with _writing(path):
        path.unlink(missing_ok=True)
        path.with_name(f"{path.name}.lock").unlink(missing_ok=True)


def _read(path: Path, file: BinaryIO, task: dict[str, str]) -> dict[str, Any]:
    """Return the finished items; an incomplete last line is cut off, unless it is no journal."""
    file.seek(0)
    text = file.read()
    # What a kill cut off is the last line alone: each line is one call.
    complete = text[: text.rfind(b"\n") + 1]
    values: dict[str, Any] = {}
    if complete or not (_START.startswith(text) or text.startswith(_START)):
        try:
            header, *lines = map(json.loads, (complete or text).splitlines())
            _refuse_other_task(path, _task_of(header), task)
            values = dict(lines)
        except (AttributeError, ValueError, TypeError, KeyError) as error:
            raise DataError(
                f"{path} is damaged, or is not a list of jobs in this format",
                hint="remove it to start again",
            ) from error
    with _writing(path):
        if len(complete) < len(text):
            os.ftruncate(file.fileno(), len(complete))
        if not complete:
            _append(file, {"format": FORMAT, "of": task})
    return values


def _task_of(header: Mapping[str, Any]) -> Mapping[str, str]:
    if header["format"] != FORMAT:
        raise ValueError(header["format"])
    task: Mapping[str, str] = header["of"]
    return task


def _refuse_other_task(path: Path, then: Mapping[str, str], now: Mapping[str, str]) -> None:
    for name in sorted(then.keys() | now.keys()):
        if then.get(name) != now.get(name):
            raise UsageError(
                f"{path} has results of other work: {name} was {then.get(name)}, is"
                f" {now.get(name)}",
                hint="remove it to start again, or choose another place",
            )


def _append(file: BinaryIO, line: Any) -> None:
    """Write a line in one call; raise OSError if the disk had room for only a part of it."""
    text = json.dumps(line).encode() + b"\n"
    if file.write(text) != len(text):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise DataError(
            f"cannot write {path}: {error.strerror or error}",
            hint="is the disk full or read-only, or do you have no permission to write there?",
        ) from error
