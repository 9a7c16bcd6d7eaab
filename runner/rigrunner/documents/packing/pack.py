"""Write a run folder to one file."""

from __future__ import annotations

from stat import S_IFREG
from typing import TYPE_CHECKING
from zipfile import ZIP_STORED, ZipFile, ZipInfo

from rigrunner.api.errors import DataError, UsageError
from rigrunner.documents.packing.contents import (
    LISTING,
    Contents,
    PackedFile,
    copy_digest,
    is_hidden,
    is_safe,
    require_sound,
)
from rigrunner.run.locate import RUN_FILE
from rigrunner.runfile.durable import publish, temporary, writing

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

_NO_DATE = (1980, 1, 1, 0, 0, 0)
"""The earliest date of a ZIP: the same run gives the same bytes."""
_EXCLUDED = ("run.lock",)


def pack(folder: Path, target: Path) -> Contents:
    """Write a sealed run to one new file, and return its list of contents.

    Raises UsageError if the file exists, and DataError for a run that is not sealed, was changed
    since, or has a file name that not every system accepts.
    """
    if target.exists():
        raise UsageError(f"{target} exists", hint="a packed run is never overwritten")
    sealed = folder / RUN_FILE
    if not sealed.is_file():
        raise DataError(
            f"{folder} is not sealed",
            hint="'rigrunner resume' or 'rigrunner recover' ends it first",
        )
    info = require_sound(sealed)
    contents = Contents(
        folder=folder.resolve().name,
        run=info.header.run_id,
        digest_sha256=info.digest,
        manifest_sha256=info.manifest_sha256,
        files=tuple(_packed_files(folder)),
    )
    if not is_safe(contents.folder):
        raise DataError(
            f"not every operating system allows the name '{contents.folder}'", hint="rename it"
        )
    with writing(target):
        try:
            _write(contents, folder, temporary(target))
        except BaseException:
            temporary(target).unlink(missing_ok=True)
            raise
        publish(target, read_only=True)
    return contents


def _packed_files(folder: Path) -> Iterator[PackedFile]:
    paths = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*")}
    for name, path in sorted(paths.items()):  # the order of a file system varies
        if is_hidden(name):  # such as files of a file manager; `unpack` would refuse them
            continue
        if path.is_symlink() or not (path.is_file() or path.is_dir()):
            raise DataError(f"{path} is not a regular file", hint="remove it from the run folder")
        if path.is_dir() or name in _EXCLUDED:
            continue
        if not is_safe(name):
            raise DataError(
                f"not every operating system allows the name '{name}'", hint="rename it"
            )
        with path.open("rb") as file:
            sha256, size = copy_digest(file)
        yield PackedFile(name=name, bytes=size, sha256=sha256)


def _write(contents: Contents, folder: Path, target: Path) -> None:
    with ZipFile(target, "w", ZIP_STORED) as packed:
        packed.writestr(_entry(LISTING), contents.text())
        for file in contents.files:
            entry = _entry(f"{contents.folder}/{file.name}", file.bytes)
            with (folder / file.name).open("rb") as source, packed.open(entry, "w") as member:
                sha256, _ = copy_digest(source, member)
            if sha256 != file.sha256:  # `unpack` would refuse all of it
                raise DataError(f"{folder / file.name} was changed meanwhile", hint="pack it again")


def _entry(name: str, size: int = 0) -> ZipInfo:
    entry = ZipInfo(name, _NO_DATE)
    entry.file_size = size  # so that one beyond 4 GB gets the form for it
    entry.create_system = 3  # Unix, also on Windows: the mode below holds, and the same bytes
    mode = 0o444 if name.endswith(f"/{RUN_FILE}") else 0o644
    entry.external_attr = (S_IFREG | mode) << 16
    return entry
