"""Turn a checked import into a sealed run and its report."""

from __future__ import annotations

import hashlib
import shutil
from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.api.events import Outcome
from rigrunner.api.progress import unseen
from rigrunner.clock import utc_text
from rigrunner.run.finish import finish
from rigrunner.run.provenance import SIMULATED, software
from rigrunner.run.record import header_of, open_log
from rigrunner.runfile import RunWriter, create_run_folder, run_lock
from rigrunner.tools.importing.writing import write_run

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.progress import Progress
    from rigrunner.engine import Override
    from rigrunner.run.finish import FinishedRun
    from rigrunner.runfile import RunHeader
    from rigrunner.tools.importing.mapping import LoadedMapping
    from rigrunner.tools.importing.planning import PlannedImport


def import_run(
    checked: PlannedImport,
    *,
    runs: Path,
    partners: Mapping[str, Path],
    overrides: Sequence[Override] = (),
    progress: Progress = unseen,
) -> FinishedRun:
    """Read the recordings into a run folder, seal it and write the report.

    If a recording cannot be read, nothing is left: raises InvalidFileError or DataError.
    """
    planned, mapping = checked.planned, checked.mapping
    inputs = checked.matched.inputs
    started = planned.clock.utc()
    folder = create_run_folder(
        runs, started, planned.procedure.model.id, inputs.get("specimen", "")
    )
    errors: list[BaseException] = []
    is_recorded = False
    try:
        with run_lock(folder):
            files = dict.fromkeys(part.file for _, part in mapping.model.parts())
            digests = {name: _digest(mapping.file(name)) for name in files}
            header = _header(checked, folder.name, digests)
            with RunWriter(folder, header) as writer, open_log(folder) as log:
                write_run(checked, [writer, *log], folder.name, overrides, progress)
            _check_unchanged(mapping, digests)
            is_recorded = True
            end = (Outcome.COMPLETED, "", ())
            return finish(planned, writer, end, partners, errors, progress=progress)
    except BaseException:
        if not is_recorded:  # its sources are complete; the lock is released:
            shutil.rmtree(folder, ignore_errors=True)  # Windows removes no file that is open
        raise


def _digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror or error}") from error


def _check_unchanged(mapping: LoadedMapping, digests: Mapping[str, str]) -> None:
    for name, digest in digests.items():
        if _digest(mapping.file(name)) != digest:
            raise DataError(
                f"{mapping.file(name)} was changed while it was read",
                hint="import again once the program that writes it is done",
            )


def _header(checked: PlannedImport, run_id: str, digests: Mapping[str, str]) -> RunHeader:
    planned, mapping, inputs = checked.planned, checked.mapping, checked.matched.inputs
    model = mapping.model
    devices = {
        f"device {role}": f"recorded by {model.program}"
        # recordings of a simulated station stay simulated
        + (SIMULATED if planned.registry.is_simulated(binding.plugin, binding.settings) else "")
        for role, binding in planned.station.model.devices.items()
    }
    imported = {
        "program": model.program,
        "by": model.by,
        "importer": checked.reader,
        "utc": utc_text(datetime.now(UTC)),
        "mapping": mapping.path.name,
        "mapping SHA-256": mapping.digest,
        **{f"file {name}": digest for name, digest in digests.items()},
    }
    return replace(
        header_of(planned, run_id, inputs),
        people={"operator": name} if (name := inputs.get("operator", "")) else {},
        provenance=software(planned.registry) | devices,
        imported=imported,
        mapping_text=mapping.text,
    )
