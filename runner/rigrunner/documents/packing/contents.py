"""The list of contents of a packed run, the file names that it may have, and its bytes.

Members are stored, not compressed (`run.h5` is compressed already). So the same run always gives
the same bytes, and the members are never larger than the file.
"""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import PurePosixPath
from typing import IO, TYPE_CHECKING, Literal

from pydantic import ValidationError

from rigrunner.api.errors import DataError, first_problem
from rigrunner.api.settings import Settings
from rigrunner.runfile import file_differences, read_info, refuse_crashing

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.runfile import RunInfo

LISTING = "rigrunner-packed-run.json"
LONGEST_LISTING = 1 << 24
"""Longest list, in bytes."""
_BLOCK = 1 << 20
_NAME = re.compile(r"[^\x00-\x1f\\:*?\"<>|/]{1,200}")
"""A part of a path that every operating system accepts."""
_DEVICES = re.compile(r"(con|prn|aux|nul|con(in|out)\$|(com|lpt)[\d¹²³])(\..*)?", re.IGNORECASE)
"""Names of devices on Windows."""


class PackedFile(Settings):
    """A file of the run folder."""

    name: str
    """Path in the run folder, with '/'."""
    bytes: int
    sha256: str


class Contents(Settings):
    """The list of contents of a packed run."""

    format: Literal["rigrunner: packed run/1"] = "rigrunner: packed run/1"
    folder: str
    """The name of the run folder."""
    run: str
    """The run's id."""
    digest_sha256: str
    """Digest of its recordings and measurements, as in the run file."""
    manifest_sha256: str
    """Digest of the manifest of the run file; '' if it has none."""
    files: tuple[PackedFile, ...]

    def text(self) -> str:
        """Return the text of the list in the packed file."""
        return json.dumps(self.model_dump(mode="json"), ensure_ascii=False, indent=1) + "\n"

    @property
    def members(self) -> list[str]:
        """The names in the packed file, in order."""
        return [LISTING, *(f"{self.folder}/{file.name}" for file in self.files)]


def parse_contents(text: bytes) -> Contents:
    """Return the list at the beginning of a packed file; raise DataError."""
    try:
        contents = Contents.model_validate_json(text)
    except ValidationError as error:
        what = first_problem(error, "it")
        raise DataError(f"its list of files is not valid: {what}") from error
    names = [file.name for file in contents.files]
    unsafe = next((name for name in [contents.folder, *names] if not is_safe(name)), None)
    if unsafe is not None or "/" in contents.folder:
        raise DataError(
            f"a name in it leads out of the folder, or is not allowed on every system: {unsafe!r}"
        )
    # Some systems take names that differ in case alone for one file.
    if len({name.casefold() for name in names}) < len(names):
        raise DataError("its list names a file twice")
    return contents


def is_safe(name: str) -> bool:
    """Return whether a path stays in its folder on every system, and is not hidden.

    Hidden files and folders can be more than data: a `.git` or `.vscode` has commands that programs
    run when they only open its folder.
    """
    parts = name.split("/")
    return PurePosixPath(name).as_posix() == name and all(
        _NAME.fullmatch(part)
        and part.isprintable()
        and not is_hidden(part)
        and part == part.rstrip(". ")
        and not _DEVICES.fullmatch(part)
        for part in parts
    )


def is_hidden(name: str) -> bool:
    """Return whether a file, or a folder in its path, is hidden."""
    return any(part.startswith(".") for part in name.split("/"))


def copy_digest(source: IO[bytes], out: IO[bytes] | None = None) -> tuple[str, int]:
    """Return the digest and the size in bytes of the rest of a file, copied to `out` if given."""
    digest, size = hashlib.sha256(), 0
    while block := source.read(_BLOCK):
        digest.update(block)
        size += len(block)
        if out is not None:
            out.write(block)
    return digest.hexdigest(), size


def require_sound(file: Path) -> RunInfo:
    """Return the contents of a run file; raise DataError if it is damaged."""
    refuse_crashing(file)
    differences = file_differences(file)
    if differences:
        raise DataError(
            f"{file} has changed since it was sealed: {differences[0]}",
            hint=f"'rigrunner verify {file}' lists all that differs",
        )
    return read_info(file)
