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
from rigrunner_fleet.golden.reference import REFERENCE, Found, Reference, found_in, write_reference
from rigrunner_fleet.reanalysis.batch import RESULT, Batch

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from rigrunner.api.devices import StopToken
    from rigrunner.jobs import Workers
    from rigrunner_fleet.reanalysis.changes import Changes
    from rigrunner_fleet.reanalysis.selection import Chosen
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
    changes: Changes
    station: str | None
    workers: Workers
    stop: StopToken
    progress: Callable[[int, int], None]

    def record(self, runs: Sequence[Chosen]) -> Recorded:
        """Analyse the runs and write a reference for each.

        A refused analysis is recorded too. Raises UsageError if the folder has a reference of one
        of them already, DataError for a run that cannot be read, and AbortedError once the token is
        set.
        """
        known = [run.name for run in runs if (self.out / run.name / REFERENCE).exists()]
        if known:
            raise UsageError(
                f"'{known[0]}' is golden already in {self.out}",
                hint="remove its folder there if what it gives now is to be the reference",
            )
        with results_folder(None) as folder:
            batch = Batch(
                folder, self.changes, self.station, self.workers, self.stop, self.progress
            )
            found = batch.run(runs)
            rows = {row.run: row for row in (*found.analysed, *found.failed)}
            made_by = how_made(self.station, self.changes)
            references = [
                self._reference(run, rows[run.name], folder, made_by)
                for run in runs
                if run.name in rows
            ]
        for reference in references:
            write_reference(self.out, reference)
        return Recorded(tuple(references), found.skipped)

    def _reference(
        self, run: Chosen, row: Row, results: Path, made_by: Mapping[str, str]
    ) -> Reference:
        info = read_info(run.path)
        document = read_result(results, run.name)
        return Reference(
            name=run.name,
            run=info.header.run_id,
            at=self._kept(run),
            digest_sha256=info.digest,
            no_load_sha256=no_load_digest(document),
            made_by=dict(made_by),
            found=Found(problem=row.problem) if document is None else found_in(document),
        )

    def _kept(self, run: Chosen) -> str:
        """Return the path of the run from the folder; copy it if asked."""
        if not self.copy:
            return Path(os.path.relpath(run.path, self.out.resolve())).as_posix()
        source = run.path / RUN_FILE if run.path.is_dir() else run.path
        target = self.out / run.name / RUN_FILE
        with writing(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
        return f"{run.name}/{RUN_FILE}"


def how_made(station: str | None, changes: Changes) -> dict[str, str]:
    """Return how results are made: software with its versions, and changed settings."""
    found = software(lab_registry(station))
    providers = {_PLACE.sub("", each) for each in found.pop(PROVIDERS).split(", ")}
    return {**found, PROVIDERS: ", ".join(sorted(providers)), SETTINGS: changes.describe()}


@contextmanager
def results_folder(kept: Path | None) -> Iterator[Path]:
    """Yield the folder for results: the given one, or a temporary one."""
    if kept is not None:
        yield kept.resolve()
        return
    with tempfile.TemporaryDirectory(prefix="rigrunner-golden-") as folder:
        yield Path(folder)


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
    found = (document or {}).get("no_load_run") or {}
    return str(found.get("digest_sha256", ""))
