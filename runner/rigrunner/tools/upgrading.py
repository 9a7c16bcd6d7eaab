"""Write files in the current form of the language, and keep the older ones."""

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

OLD_SUFFIX = ".old"
"""The suffix of the kept file."""


@dataclass(frozen=True)
class Upgrade:
    """A file with its current and its upgraded text."""

    path: Path
    before: str
    after: str
    out: Path | None = None
    """The folder to write to; None replaces the file itself, and keeps the older one under another
    name."""

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
        """The file with the older text."""
        return self.path if self.out else self.path.with_name(self.path.name + OLD_SUFFIX)

    @property
    def is_procedure(self) -> bool:
        """Whether it is a procedure, which needs approval."""
        return str(parse(self.after, str(self.path)).data[MARK]).startswith("procedure/")

    def diff(self) -> str:
        """Return the changes line by line, as `diff -u` prints them."""
        before, after = (text.splitlines() for text in (self.before, self.after))
        names = str(self.path), str(self.target)
        return "\n".join(unified_diff(before, after, *names, lineterm=""))


def upgrade_of(path: Path, out: Path | None) -> Upgrade:
    """Return a file with its text in the current form; raise InvalidFileError."""
    text = read_text(path)
    return Upgrade(path, text, upgraded(text, str(path)), out)


def write_upgrades(upgrades: Sequence[Upgrade]) -> None:
    """Write the files, or none if a file is in the way of one; then raise UsageError."""
    taken: set[Path] = set()
    for upgrade in upgrades:
        new = upgrade.kept if upgrade.out is None else upgrade.target
        if new.exists():
            raise UsageError(f"there is a file {new}", hint="nothing was written; move it away")
        if new in taken:
            message = f"two of the files would be written to {new}"
            raise UsageError(message, hint="nothing was written; give each another folder")
        taken.add(new)
    for upgrade in upgrades:
        try:
            if upgrade.out is None:
                _write_new(upgrade.kept, upgrade.before)
                part = upgrade.path.with_name(f".{upgrade.path.name}.part")
                part.write_bytes(upgrade.after.encode())
                part.replace(upgrade.path)
            else:
                upgrade.out.mkdir(parents=True, exist_ok=True)
                _write_new(upgrade.target, upgrade.after)
        except OSError as error:
            message = f"cannot write {error.filename}: {error.strerror or error}"
            raise UsageError(message) from error


def _write_new(path: Path, text: str) -> None:
    with path.open("xb") as file:
        file.write(text.encode())
