"""Checks that a run file, and what was made from it, are genuine."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.analysis.document import document
from rigrunner.api.errors import DataError, RigrunnerError
from rigrunner.documents.verifying.revisions import methods_used, other_revisions
from rigrunner.documents.verifying.verification import Verification
from rigrunner.procedure import parse_procedure
from rigrunner.proof.compare import mismatches
from rigrunner.run.provenance import software
from rigrunner.run.stored import analyse_stored
from rigrunner.runfile import file_differences, read, refuse_crashing, sealed_file_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from rigrunner.api.results import Result
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun

RESULT_FILE = "result.json"


@dataclass(frozen=True, eq=False)
class CheckedRun:
    """A readable run, with its result recomputed, if possible."""

    path: Path
    stored: StoredRun
    result: Result | None


def verify_run(path: Path, registry: Registry) -> Verification:
    """Check a run by its manifest, and derive its result again from the raw samples.

    Raises DataError if there is no run at that path.
    """
    verification = Verification()
    check_run(verification, path, registry)
    return verification


def check_run(verification: Verification, path: Path, registry: Registry) -> CheckedRun | None:
    """Check one run; return it, or None if it cannot be read. Raises as above."""
    sealed = sealed_file_of(path)
    if sealed is None:
        verification.information.append("the run is not sealed: it has no manifest yet")
    else:
        try:
            # In a process of its own, before any other look: HDF5 crashes on some forged files.
            refuse_crashing(sealed)
        except DataError as error:
            verification.take("run file", [error])
            return None
        _check_manifest(verification, sealed)
    try:
        stored = read(path)
    except DataError as error:
        if verification.matches:  # else the manifest reported already what is wrong
            verification.take("run file", [error])
        text = "its result was not recomputed: the file must be sound first"
        verification.information.append(text)
        return None
    count = len(stored.recordings)
    verification.held.append(f"recordings: {count} with the digest {stored.digest}")
    if salvaged := stored.header.salvaged:
        verification.unchecked.append(
            f"the run was salvaged from {salvaged.get('file')} (SHA-256 {salvaged.get('sha256')}),"
            " which is damaged: it lacks what is lost, and is never certified"
        )
    result = _check_result(verification, stored, path, registry)
    now = software(registry)
    verification.information.extend(versions(stored.header.provenance, now, "was recorded"))
    return CheckedRun(path, stored, result)


def _check_manifest(verification: Verification, sealed: Path) -> None:
    try:
        differences = file_differences(sealed)
    except DataError as error:
        verification.take("run file", [error])
        return
    if differences is None:
        verification.information.append(
            "the file was sealed without a manifest, by an older version:"
            " digests cover its recordings and measurements alone"
        )
    else:
        verification.take("manifest of the run file", differences)


def _check_result(
    verification: Verification, stored: StoredRun, path: Path, registry: Registry
) -> Result | None:
    """Derive the result again and compare it; return it, or None if impossible.

    Only the methods that derived it are used, since another revision may give other numbers.
    """
    recorded = stored.result_document
    if recorded is None:
        verification.information.append("the run holds no result, so none was recomputed")
        return None
    what = "result recomputed from the raw samples"
    result = None
    try:
        header = stored.header
        procedure = parse_procedure(header.procedure_text, header.procedure_id, stored=True).model
        methods, revisions = methods_used(procedure, registry), recorded.get("revisions", {})
        differing = list(other_revisions(methods, revisions, header.provenance, registry))
        verification.not_recomputed.extend(differing)
        if not differing:
            result = analyse_stored(stored, registry)
    except RigrunnerError as error:
        verification.take(what, [f"it cannot be derived: {error}"])
        return None
    if result is not None:
        # as after writing and reading: the recorded one was read from its file
        derived = json.loads(json.dumps(document(result)))
        verification.take(what, mismatches(recorded, derived))
    if (file := path / RESULT_FILE).exists():
        verification.attempt(RESULT_FILE, lambda: _file_differences(recorded, file))
    return result


def _file_differences(recorded: Mapping[str, object], path: Path) -> Iterator[object]:
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError) as error:
        raise DataError(f"{path} cannot be read: {error}") from error
    if content != recorded:
        differences: list[object] = list(mismatches(recorded, content))
        yield from differences or ["it is not the result that is in the run file"]


def versions(then: Mapping[str, str], now: Mapping[str, str], what: str) -> Iterator[str]:
    """Yield versions that differ from the recorded ones, as text."""
    for name, version in now.items():
        if name in then and then[name] != version:
            yield f"{name}: {then[name]} when it {what}, {version} now"
