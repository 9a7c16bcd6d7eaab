"""Reads and writes the procedures in the laboratory's folder; the files are the only copy."""

from __future__ import annotations

import hashlib
import os
import re
import threading
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.yamlfile.reader import MAX_BYTES, read_text
from rigrunner_panel.catalogue import kind_of
from rigrunner_panel.errors import PanelError

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner_panel.catalogue import Catalogue

_NAME = re.compile(r"(procedures/)?\w[\w-]*(\.[\w-]+)*\.ya?ml", re.ASCII)
_DEVICE = re.compile(r"(.*/)?(con|prn|aux|nul|com\d|lpt\d)\..*", re.ASCII | re.IGNORECASE)
"""Names that Windows gives to devices, with any ending."""
LONGEST_NAME = 100


@dataclass(frozen=True)
class ProcedureText:
    """The content of a procedure file when it was read."""

    path: Path
    text: str
    digest: str
    """SHA-256 of the file's bytes, hexadecimal."""


class ProcedureFiles:
    """Reads and replaces the procedures in the laboratory's folder, and no other files."""

    def __init__(self, folder: Path, catalogue: Catalogue) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._lock = threading.Lock()

    def place(self, name: str) -> Path:
        """Return the file of that name in the list; raise PanelError, of a link out of the folder.

        A shipped one is in the list, too.
        """
        path = self._catalogue.path("procedure", name)
        if not self.is_shipped(name):
            self._require_inside(path, name)
        return path

    def is_shipped(self, name: str) -> bool:
        """Return whether a listed name is a shipped procedure's, which has no file extension."""
        return not name.endswith((".yaml", ".yml"))

    def read(self, name: str) -> ProcedureText:
        """Return a file's content; raise PanelError, or InvalidFileError if it is not text."""
        path = self.place(name)
        text = read_text(path)
        return ProcedureText(path, text, digest_of(path))

    def write(self, name: str, text: str, digest: str) -> str:
        """Replace a file that still has the given digest, or create a new one if the digest is ''.

        Returns the new digest. Raises PanelError if the name or text is not valid for a procedure,
        and ChangedError if the file was changed.
        """
        path = self._to_write(name)
        content = text.encode()
        if len(content) > MAX_BYTES:
            raise PanelError(413, "too_long", f"the procedure is longer than {MAX_BYTES:,} bytes")
        if kind_of(content) != "procedure":
            hint = "its first line is 'rigrunner: procedure/2'"
            raise PanelError(422, "invalid", "the text is not marked as a procedure", hint)
        with self._lock:
            if digest_of(path) != digest:
                raise ChangedError(name)
            _replace(path, content)
        return digest_of(path)

    def _to_write(self, name: str) -> Path:
        with suppress(PanelError):
            if not self.is_shipped(name):
                return self.place(name).resolve()
        if len(name) > LONGEST_NAME or not _NAME.fullmatch(name) or _DEVICE.fullmatch(name):
            message = f"'{name[:LONGEST_NAME]}' is not a name for a procedure"
            hint = "letters, digits, '-' and '_', ending with .yaml; such as procedures/wear.yaml"
            raise PanelError(422, "invalid", message, hint)
        path = self._folder / name
        self._require_inside(path, name)
        if path.exists():
            raise PanelError(409, "wrong_state", f"the file {name} exists and is not a procedure")
        if not path.parent.is_dir():
            raise PanelError(422, "invalid", f"the lab's folder has no folder '{path.parent.name}'")
        return path

    def _require_inside(self, path: Path, name: str) -> None:
        with suppress(OSError, RuntimeError):  # links in a circle
            if path.resolve().is_relative_to(self._folder.resolve()):
                return
        hint = "only files within the folder can be opened here"
        raise PanelError(422, "invalid", f"{name} is outside the lab's folder", hint)


class ChangedError(Exception):
    """A file was changed after it was opened."""


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file, hexadecimal; '' if it does not exist."""
    try:
        with path.open("rb") as file:
            return hashlib.sha256(file.read(MAX_BYTES + 1)).hexdigest()
    except OSError:
        return ""


def _replace(path: Path, content: bytes) -> None:
    """Replace a file atomically; raise PanelError."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.unlink(missing_ok=True)
        with part.open("xb") as file:  # does not follow a link
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            part.chmod(path.stat().st_mode & 0o777)
        part.replace(path)
    except OSError as error:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        message = f"{path.name} cannot be written: {error.strerror}"
        raise PanelError(422, "invalid", message) from error
