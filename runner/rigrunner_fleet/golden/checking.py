"""Analyses golden runs with the installed software and compares with their references."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.runfile import read, refuse_crashing, sealed_file_of
from rigrunner_fleet.golden.comparing import by_severity, compare, not_compared
from rigrunner_fleet.golden.overall import Overall
from rigrunner_fleet.golden.recording import (
    PROVIDERS,
    no_load_digest,
    read_result,
    results_folder,
    software_used,
)
from rigrunner_fleet.golden.reference import Snapshot, read_references
from rigrunner_fleet.reanalysis.selection import SelectedRun

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from rigrunner_fleet.golden.comparing import Comparison
    from rigrunner_fleet.golden.reference import Reference
    from rigrunner_fleet.reanalysis.batch import Batch
    from rigrunner_fleet.reanalysis.task import Row


@dataclass(frozen=True, kw_only=True)
class Checker:
    """Compares golden runs with their references."""

    folder: Path
    """Folder of the references."""
    runs: Path | None
    """Folder of the runs; None: the paths in the references."""
    tolerance: float
    """In expanded uncertainties."""
    out: Path | None
    """Folder for results, from which an interrupted check resumes; None for none."""
    batch: Batch

    def check(self) -> Overall:
        """Analyse every golden run again and compare; raise as `Batch.run` does."""
        references = read_references(self.folder)
        folder, runs = self.folder.resolve(), self.runs and self.runs.resolve()
        chosen = {
            reference.name: SelectedRun(
                reference.name, runs / reference.name if runs else reference.path(folder)
            )
            for reference in references
        }
        existing = [run for run in chosen.values() if run.path.exists()]
        with results_folder(self.out) as results:
            summary = self.batch.run(existing, results)
            rows = {row.run: row for row in (*summary.done, *summary.failed)}
            compared = [
                self._compare(reference, chosen[reference.name], rows.get(reference.name), results)
                for reference in references
            ]
        return Overall(
            runs=tuple(sorted(compared, key=by_severity)),
            tolerance=self.tolerance,
            made_by=_changed_versions(references, software_used(self.batch)),
        )

    def _compare(
        self, reference: Reference, run: SelectedRun, row: Row | None, results: Path
    ) -> Comparison:
        before = reference.found
        if row is None:
            problem = f"there is no {run.path}"
            return not_compared(reference.name, before, Snapshot(problem=problem), problem)
        document = None if row.problem or row.skipped else read_result(results, reference.name)
        after = Snapshot(problem=row.problem or row.skipped or "no result")
        if document is not None:
            after = Snapshot.of(document)
        problem = _other_data(reference, run, row, document)
        if problem:
            return not_compared(reference.name, before, after, problem)
        return compare(reference.name, before, after, self.tolerance)


def _other_data(
    reference: Reference, run: SelectedRun, row: Row, document: Mapping[str, object] | None
) -> str:
    """Return why the run is not the golden one, or cannot be read; '' if it is."""
    if document is None:
        try:
            sealed = sealed_file_of(run.path)
            if sealed is not None:
                refuse_crashing(sealed)
            digest = read(run.path).digest
        except DataError as error:
            return str(error)
        return "" if digest == reference.digest_sha256 else "it is another run, by its digest"
    run_facts: Mapping[str, object] = document["run"]  # type: ignore[assignment]  # plain JSON
    if run_facts["digest_sha256"] != reference.digest_sha256:
        return f"{row.run_id} is another run than the golden one, {reference.run}, by its digest"
    if reference.no_load_sha256 and no_load_digest(document) != reference.no_load_sha256:
        return "the no-load run in its file is another one, by its digest"
    return ""


def _changed_versions(
    references: Iterable[Reference], installed: Mapping[str, str]
) -> tuple[tuple[str, str, str], ...]:
    """Return (name, versions in the references, versions now) of everything that changed."""
    recorded: dict[str, set[str]] = {}
    for reference in references:
        for name, version in reference.made_by.items():
            recorded.setdefault(name, set()).update(_parts(name, version))
    now = {name: _parts(name, version) for name, version in installed.items()}
    return tuple(
        (name, _text(versions - now.get(name, set())), _text(now.get(name, set()) - versions))
        for name, versions in recorded.items()
        if versions != now.get(name)
    )


def _parts(name: str, version: str) -> set[str]:
    return set(version.split(", ")) if name == PROVIDERS else {version}


def _text(versions: set[str]) -> str:
    return " or ".join(sorted(versions)) or "none other"
