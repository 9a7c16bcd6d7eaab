"""The folder of a run: its name, and the paths of its files."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from datetime import UTC
from itertools import count
from typing import TYPE_CHECKING

from rigrunner.runfile.durable import sync_folder, writing

if TYPE_CHECKING:
    from datetime import datetime
    from pathlib import Path

_LONGEST_PART = 48


def create_run_folder(
    runs: Path, started: datetime, procedure_id: str, specimen: str = "", mark: str = ""
) -> Path:
    """Create and return `<UTC>_<procedure>_<specimen>` in `runs`; its name is the run's id.

    A `mark` is appended. If the name exists, '-2', '-3', ... is added. Raises DataError if it
    cannot be created.
    """
    parts = (started.astimezone(UTC).strftime("%Y%m%dT%H%M%SZ"), procedure_id, specimen, mark)
    name = "_".join(safe for part in parts if (safe := safe_name(part)))
    with writing(runs / name):
        runs.mkdir(parents=True, exist_ok=True)
        folder = _first_free(runs, name)
        sync_folder(runs)
    return folder


def safe_name(text: str) -> str:
    """Return a text that every file system accepts: letters, digits, dash, dot in the middle."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return re.sub(r"[^A-Za-z0-9.]+", "-", plain)[:_LONGEST_PART].strip("-.")


def _first_free(runs: Path, name: str) -> Path:
    for number in count(1):
        folder = runs / (name if number == 1 else f"{name}-{number}")
        # `mkdir` decides, not a look before: two runs may begin in the same second.
        try:
            folder.mkdir()
        except FileExistsError:
            continue
        return folder
    raise AssertionError


@dataclass(frozen=True)
class RunFolder:
    """The files of one run."""

    path: Path

    @property
    def sealed_file(self) -> Path:
        """The whole run, after its end."""
        return self.path / "run.h5"

    @property
    def is_run(self) -> bool:
        """Whether there is a run, sealed or not."""
        return self.sealed_file.exists() or self.events.exists()

    @property
    def lock(self) -> Path:
        """The lock file of the process that writes to the run."""
        return self.path / "run.lock"

    @property
    def journal(self) -> Path:
        """The folder of the journals, while the run lasts."""
        return self.path / "journal"

    @property
    def events(self) -> Path:
        """The journal of header, events and truth."""
        return self.journal / "events.journal"

    @property
    def parts(self) -> Path:
        """The folder of finished recordings, one file each."""
        return self.path / "recordings"

    def samples(self, number: int) -> Path:
        """Return the journal of the blocks of the recording with that number in the run."""
        return self.journal / f"{number:06d}.samples"

    def part(self, number: int) -> Path:
        """Return the file of the finished recording with that number in the run."""
        return self.parts / f"{number:06d}.h5"

    def sample_journals(self) -> list[Path]:
        """Return the journals of blocks that are on disk, in order."""
        return sorted(self.journal.glob("*.samples"))

    def finished_parts(self) -> list[Path]:
        """Return the files of finished recordings that are on disk, in order."""
        return sorted(self.parts.glob("*.h5"))
