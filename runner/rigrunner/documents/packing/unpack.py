"""Unpack a run folder from one file, which may come from anyone."""

from __future__ import annotations

import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from zipfile import ZIP_STORED, BadZipFile, ZipFile

from rigrunner.api.errors import DataError, UsageError
from rigrunner.documents.packing.contents import (
    LISTING,
    LONGEST_LISTING,
    copy_digest,
    parse_contents,
    require_sound,
)
from rigrunner.run.locate import RUN_FILE
from rigrunner.runfile.durable import READ_ONLY, sync_file, sync_folder, writing

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.documents.packing.contents import Contents

_ENCRYPTED = 0x1  # bit 0 of the general purpose flag (APPNOTE.TXT of PKWARE, 4.4.4)


def unpack(packed: Path, runs: Path) -> Path:
    """Unpack a packed run into a folder of runs, and return its run folder.

    It appears complete or not at all. Raises UsageError if a run of that name exists, and DataError
    for a file that is not a packed run, or if anything differs from its digests.
    """
    with _open(packed) as file:
        contents = _contents(packed, file)
        target = runs / contents.folder
        if target.exists():
            raise UsageError(f"{target} exists", hint="a run is never overwritten")
        with writing(target):
            runs.mkdir(parents=True, exist_ok=True)
            temporary = Path(tempfile.mkdtemp(prefix=".unpacking-", dir=runs))
        try:
            with writing(target):
                _extract(packed, file, contents, temporary)
            _require_same(packed, contents, temporary / RUN_FILE)
            with writing(target):
                # not before: Windows removes no file that is read-only
                (temporary / RUN_FILE).chmod(READ_ONLY)
                temporary.chmod(0o755)  # a temporary folder is its owner's alone
                temporary.rename(target)
                sync_folder(runs)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
    return target


def _contents(packed: Path, file: ZipFile) -> Contents:
    entries = file.infolist()
    if not entries or entries[0].filename != LISTING:
        raise DataError(f"{packed} is a ZIP, but not a packed run")
    if entries[0].file_size > LONGEST_LISTING:  # before it is read into memory
        raise DataError(f"{packed}: its list of files is too long")
    for entry in entries:
        if entry.compress_type != ZIP_STORED or entry.flag_bits & _ENCRYPTED:
            raise DataError(
                f"{packed}: '{entry.filename}' is compressed or encrypted",
                hint="'rigrunner pack' writes neither",
            )
    # Entries that overlap give more than the file holds.
    if sum(entry.file_size for entry in entries) > packed.stat().st_size:
        raise DataError(f"{packed} states more data than the file has")
    try:
        contents = parse_contents(file.read(entries[0]))
    except DataError as error:
        raise DataError(f"{packed}: {error.message}") from error
    names = [entry.filename for entry in entries]
    if names != contents.members or RUN_FILE not in {each.name for each in contents.files}:
        raise DataError(f"{packed} does not contain the files in its list")
    return contents


def _extract(packed: Path, file: ZipFile, contents: Contents, place: Path) -> None:
    for packed_file in contents.files:
        target = place / packed_file.name
        target.parent.mkdir(parents=True, exist_ok=True)
        with file.open(f"{contents.folder}/{packed_file.name}") as source, target.open("xb") as out:
            sha256, _ = copy_digest(source, out)
        if sha256 != packed_file.sha256:
            raise DataError(f"{packed}: '{packed_file.name}' does not match its SHA-256")
        sync_file(target)


def _require_same(packed: Path, contents: Contents, sealed: Path) -> None:
    try:
        info = require_sound(sealed)
    except DataError as error:
        words = error.message.replace(str(sealed), RUN_FILE)
        raise DataError(f"{packed}: {words}") from error
    identity = (info.header.run_id, info.digest, info.manifest_sha256)
    if identity != (contents.run, contents.digest_sha256, contents.manifest_sha256):
        raise DataError(f"{packed}: its {RUN_FILE} is of another run than its list says")


@contextmanager
def _open(packed: Path) -> Iterator[ZipFile]:
    try:
        with ZipFile(packed) as file:
            yield file
    except (BadZipFile, EOFError, NotImplementedError) as error:
        raise DataError(f"{packed} is not a packed run, or is damaged: {error}") from error
    except FileNotFoundError as error:
        raise UsageError(f"there is no {packed}") from error
    except OSError as error:
        raise DataError(f"{packed} cannot be read: {error.strerror or error}") from error
