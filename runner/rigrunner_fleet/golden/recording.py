"""Record golden runs: their present results are the references of later software."""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError, UsageError
from rigrunner.run.lab_plugins import lab_registry
from rigrunner.run.locate import RUN_FILE
from rigrunner.run.provenance import software
from rigrunner.runfile import read_info
from rigrunner.runfile.durable import writing
from rigrunner_fleet.golden.reference import REFERENCE, Reference, Snapshot, write_reference
from rigrunner_fleet.reanalysis.batch import RESULT

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner_fleet.reanalysis.batch import Batch
    from rigrunner_fleet.reanalysis.selection import SelectedRun
    from rigrunner_fleet.reanalysis.task import Row

PROVIDERS = "plugin providers"
_PLACE = re.compile(r".*[/\\]")
"""The folder in the name of a lab's own plugin, which does not count: its digest does."""
SETTINGS = "changes of the procedures' own analysis"


@dataclass(frozen=True)
class Recorded:
    """The runs that became golden."""

    references: tuple[Reference, ...]
    skipped: tuple[Row, ...]
    """Runs with nothing to analyse."""


@dataclass(frozen=True)
class Recorder:
    """Records golden runs in a folder of references."""

    out: Path
    copy: bool
    """Whether the run files are copied beside their references."""
    batch: Batch

    def record(self, runs: Sequence[SelectedRun]) -> Recorded:
        """Analyse the runs and write a reference for each.

        A refused analysis is recorded too. Raises UsageError if the folder has a reference of one
        of them already, DataError for a run that cannot be read, and AbortedError once the token is
        set.
        """
        existing = [run.name for run in runs if (self.out / run.name / REFERENCE).exists()]
        if existing:
            raise UsageError(
                f"'{existing[0]}' is golden already in {self.out}",
                hint="remove its folder there if what it gives now is to be the reference",
            )
        with results_folder(None) as folder:
            summary = self.batch.run(runs, folder)
            rows = {row.run: row for row in (*summary.analysed, *summary.failed)}
            made_by = software_used(self.batch)
            references = [
                self._reference(run, rows[run.name], folder, made_by)
                for run in runs
                if run.name in rows
            ]
        for reference in references:
            write_reference(self.out, reference)
        return Recorded(tuple(references), summary.skipped)

    def _reference(
        self, run: SelectedRun, row: Row, results: Path, made_by: Mapping[str, str]
    ) -> Reference:
        info = read_info(run.path)
        document = read_result(results, run.name)
        return Reference(
            name=run.name,
            run=info.header.run_id,
            at=self._run_path(run),
            digest_sha256=info.digest,
            no_load_sha256=no_load_digest(document),
            made_by=dict(made_by),
            found=Snapshot(problem=row.problem) if document is None else Snapshot.of(document),
        )

    def _run_path(self, run: SelectedRun) -> str:
        """Return the path of the run from the folder; copy it if asked."""
        if not self.copy:
            return Path(os.path.relpath(run.path, self.out.resolve())).as_posix()
        source = run.path / RUN_FILE if run.path.is_dir() else run.path
        target = self.out / run.name / RUN_FILE
        with writing(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
        return f"{run.name}/{RUN_FILE}"


def software_used(batch: Batch) -> dict[str, str]:
    """Return how results are made: software with its versions, and changed settings."""
    versions = software(lab_registry(batch.station))
    providers = {_PLACE.sub("", provider) for provider in versions.pop(PROVIDERS).split(", ")}
    return {**versions, PROVIDERS: ", ".join(sorted(providers)), SETTINGS: batch.changes.describe()}


@contextmanager
def results_folder(folder: Path | None) -> Iterator[Path]:
    """Yield the folder for results: the given one, or a temporary one."""
    if folder is not None:
        yield folder.resolve()
        return
    with tempfile.TemporaryDirectory(prefix="rigrunner-golden-") as temporary:
        yield Path(temporary)


def read_result(folder: Path, name: str) -> Mapping[str, Any] | None:
    """Return the result of a run in a folder of results; None if it has none."""
    file = folder / name / RESULT
    if not file.exists():
        return None
    try:
        document: Mapping[str, Any] = json.loads(file.read_bytes())
    except (OSError, ValueError) as error:
        raise DataError(f"{file} cannot be read: {error}") from error
    return document


def no_load_digest(document: Mapping[str, Any] | None) -> str:
    """Return the digest of the no-load recordings that a result rests on; '' without any."""
    no_load_run = (document or {}).get("no_load_run") or {}
    return str(no_load_run.get("digest_sha256", ""))
