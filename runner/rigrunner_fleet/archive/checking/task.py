"""Check one run folder, at a limited rate: whether every file is there and unchanged."""

from __future__ import annotations

import hashlib
import os
import time
from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.runfile import file_differences, read, read_info
from rigrunner.runfile.scan import storable
from rigrunner_fleet.archive.run_facts import RUN_FILE

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from pathlib import Path

_BLOCK = 1 << 18
"""The most bytes that are read at once."""
_NICE = 10
_NO_CONTENT = ("run.lock",)
"""Temporary files."""


class Kind(StrEnum):
    """What is wrong with a file."""

    DAMAGED = "damaged"
    """It differs from its own digests, or cannot be read."""
    MISSING = "missing"
    CHANGED = "changed"
    """It is intact, but not the file that was indexed."""
    UNKNOWN = "unknown"
    """It did not exist when its run was indexed."""


@dataclass(frozen=True, order=True)
class Finding:
    """A file that is not unchanged."""

    path: str
    kind: Kind
    what: str = ""
    """Details, as text."""


@dataclass(frozen=True, kw_only=True)
class RunToCheck:
    """A run folder to check, with its state when it was indexed and last checked."""

    root: str
    """The name of its root in the archive."""
    path: str
    """The path from the root."""
    folder: Path
    sealed: bool
    manifest_sha256: str
    """The digest when it was indexed."""
    files: Mapping[str, str]
    """The SHA-256 of each file when it was indexed; '' of the run file."""
    sha256: str = ""
    """SHA-256 of the run file when it was last found intact; '' if it never was."""
    problem: str = ""
    """Why the run could not be read when it was indexed, if so."""


@dataclass(frozen=True)
class CheckedRun:
    """The findings on a run folder."""

    findings: tuple[Finding, ...]
    sha256: str
    """SHA-256 of the run file when it was last found intact; '' if it never was."""
    read_bytes: int


@dataclass
class Pace:
    """Waits so that the rate of reading stays below a limit: others use the same disk.

    Idle time does not count.
    """

    bytes_per_s: float = inf
    now: Callable[[], float] = time.monotonic
    sleep: Callable[[float], None] = time.sleep
    _due_s: float = -inf

    def take(self, size: int) -> None:
        """Wait until this many bytes are within the rate."""
        now = self.now()
        self._due_s = max(self._due_s, now) + size / self.bytes_per_s
        if self._due_s > now:
            self.sleep(self._due_s - now)


@dataclass
class RunChecker:
    """Checks run folders, one after the other, at a limited rate and with low priority."""

    pace: Pace
    yielding: bool = True
    _is_nice: bool = field(default=False, repr=False)

    def __call__(self, run: RunToCheck) -> CheckedRun:
        """Return the findings on a run folder."""
        if self.yielding and not self._is_nice and hasattr(os, "nice"):
            os.nice(_NICE)
            self._is_nice = True
        if not run.folder.is_dir():
            missing = Finding(run.path, Kind.MISSING, "the run folder is gone")
            return CheckedRun((missing,), run.sha256, 0)
        if run.problem:  # there are no digests to compare it with
            unreadable = Finding(run.path, Kind.DAMAGED, run.problem)
            return CheckedRun((unreadable,), run.sha256, 0)
        files = {storable(path.name): path for path in run.folder.iterdir() if path.is_file()}
        findings = list(_missing_and_unknown(run, set(files)))
        if not run.sealed:  # a run in progress changes all the time
            return CheckedRun(tuple(findings), run.sha256, 0)
        count = _Count(self.pace)
        sha256 = run.sha256
        for name in sorted(files.keys() & run.files.keys()):
            if name == RUN_FILE:
                run_file_findings, sha256 = _run_file(run, files[name], count)
                findings += run_file_findings
            elif name not in _NO_CONTENT:
                findings += _other_file(run, files[name], name, count)
        return CheckedRun(tuple(sorted(findings)), sha256, count.bytes)


@dataclass
class _Count:
    pace: Pace
    bytes: int = 0

    def sha256_of(self, path: Path) -> str:
        """Return the digest of a file, read at the limited rate; raise OSError."""
        digest = hashlib.sha256()
        with path.open("rb", buffering=0) as file:
            while block := file.read(_BLOCK):
                digest.update(block)
                self.bytes += len(block)
                self.pace.take(len(block))
        return digest.hexdigest()


def _missing_and_unknown(run: RunToCheck, names: set[str]) -> Iterator[Finding]:
    for name in sorted(run.files.keys() - names - set(_NO_CONTENT)):
        yield Finding(f"{run.path}/{name}", Kind.MISSING)
    if run.sealed:
        for name in sorted(names - run.files.keys() - set(_NO_CONTENT)):
            yield Finding(f"{run.path}/{name}", Kind.UNKNOWN, "it was not there when indexed")


def _other_file(run: RunToCheck, path: Path, name: str, count: _Count) -> Iterator[Finding]:
    place = f"{run.path}/{name}"
    try:
        sha256 = count.sha256_of(path)
    except OSError as error:
        yield Finding(place, Kind.DAMAGED, f"it cannot be read: {error.strerror}")
        return
    if sha256 != run.files[name]:
        yield Finding(place, Kind.CHANGED, "its SHA-256 has changed since it was indexed")


def _run_file(run: RunToCheck, path: Path, count: _Count) -> tuple[list[Finding], str]:
    """Return the findings on a run file, and the digest with which it was last found intact.

    Its own manifest is checked only if its bytes differ from those that were last found intact.
    """
    place = f"{run.path}/{RUN_FILE}"
    try:
        sha256 = count.sha256_of(path)
        difference = None if sha256 == run.sha256 else _content_difference(run, path)
    except OSError as error:
        difference = Kind.DAMAGED, f"it cannot be read: {error.strerror}"
    except DataError as error:
        difference = Kind.DAMAGED, error.message
    return ([], sha256) if difference is None else ([Finding(place, *difference)], run.sha256)


def _content_difference(run: RunToCheck, path: Path) -> tuple[Kind, str] | None:
    """Return the differences of a run file from its own digests; raise DataError."""
    differences = file_differences(path)
    if differences is None:
        read(path)  # it has no manifest: its recordings have digests of their own
    if differences:
        more = f" and {len(differences) - 1} more" if len(differences) > 1 else ""
        return Kind.DAMAGED, f"{differences[0]}{more}"
    if read_info(path).manifest_sha256 != run.manifest_sha256:
        return Kind.CHANGED, "it is intact, but not the file that was indexed"
    if run.sha256:
        return Kind.CHANGED, "its bytes have changed since the last check, but it is intact"
    return None
