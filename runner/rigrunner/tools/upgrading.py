"""Writes files in today's form of the language, and keeps them as they were."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import unified_diff
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.yamlfile.reader import parse, read_text
from rigrunner.yamlfile.upgrade import upgraded
from rigrunner.yamlfile.validation import MARK

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

KEPT = ".old"
"""What the name of a file as it was ends in."""


@dataclass(frozen=True)
class Upgrade:
    """A file as it is, and as it is to be."""

    path: Path
    before: str
    after: str
    out: Path | None = None
    """The folder to write to; None: the file itself is replaced, and kept under another name."""

    @property
    def is_needed(self) -> bool:
        """Whether the file is in an older form."""
        return self.before != self.after

    @property
    def target(self) -> Path:
        """The file that is written."""
        return self.path if self.out is None else self.out / self.path.name

    @property
    def kept(self) -> Path:
        """The file that has the older text afterwards."""
        return self.path if self.out else self.path.with_name(self.path.name + KEPT)

    @property
    def is_procedure(self) -> bool:
        """Whether it is a procedure, which somebody approves."""
        return str(parse(self.after, str(self.path)).data[MARK]).startswith("procedure/")

    def diff(self) -> str:
        """Return what changes, line by line, as `diff -u` prints it."""
        before, after = (text.splitlines() for text in (self.before, self.after))
        names = str(self.path), str(self.target)
        return "\n".join(unified_diff(before, after, *names, lineterm=""))


def upgrade_of(path: Path, out: Path | None) -> Upgrade:
    """Return a file with its text in today's form; raise InvalidFileError."""
    text = read_text(path)
    return Upgrade(path, text, upgraded(text, str(path)), out)


def write_upgrades(upgrades: Sequence[Upgrade]) -> None:
    """Write the files that need it; raise UsageError, before any is written, for one in the way."""
    for each in upgrades:
        new = each.kept if each.out is None else each.target
        if new.exists():
            raise UsageError(f"there is a file {new}", hint="nothing was written; move it away")
    for each in upgrades:
        try:
            if each.out is None:
                _write_new(each.kept, each.before)
                part = each.path.with_name(f".{each.path.name}.part")
                part.write_bytes(each.after.encode())
                part.replace(each.path)
            else:
                each.out.mkdir(parents=True, exist_ok=True)
                _write_new(each.target, each.after)
        except OSError as error:
            message = f"cannot write {error.filename}: {error.strerror or error}"
            raise UsageError(message) from error


def _write_new(path: Path, text: str) -> None:
    with path.open("xb") as file:
        file.write(text.encode())
