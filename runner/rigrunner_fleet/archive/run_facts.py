"""The facts of a run folder for an archive, read from its files alone."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError, RigrunnerError
from rigrunner.api.results import REPLAYED
from rigrunner.api.verdict import Verdict
from rigrunner.run.provenance import is_simulated
from rigrunner.runfile import read_summary
from rigrunner.runfile.scan import storable
from rigrunner_fleet.archive.documents import at, digest, key, moment, text
from rigrunner_fleet.archive.named_results import coordinates, named_results
from rigrunner_fleet.archive.result_facts import decision, figures, headline, points

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner.run.decisions import DecisionFile
    from rigrunner.runfile import RunSummary
    from rigrunner.runfile.scan import FoundRun
    from rigrunner_fleet.archive.result_facts import Row

RUN_FILE = "run.h5"
NAMED_INPUTS = ("specimen", "type", "lot", "operator")
"""Inputs of a procedure that have a column of their own."""
_DECISION_COLUMNS = ("verdict", "rule", "limit_text", "probability_of_conformity")
_LATEST_NS = (1 << 63) - 1
"""The range of a column; times of some file systems are far beyond."""


@dataclass(frozen=True)
class RunFacts:
    """The rows of one run folder."""

    found_run: FoundRun
    run: Row
    """The columns of the run itself; if it cannot be read, its `problem` alone."""
    parts: Mapping[str, list[Row]] = field(default_factory=dict)
    """The rows of tables with several rows per run, by table."""

    @property
    def problem(self) -> str:
        """Why the run cannot be read, if so."""
        return str(self.run["problem"])


def read_facts(found_run: FoundRun) -> RunFacts:
    """Read a run folder; a damaged one gives its problem instead of an error."""
    try:
        sealed = found_run.folder / RUN_FILE
        if sealed.exists() and not sealed.is_file():  # to open a pipe would never end
            raise DataError(f"{sealed} is not a regular file")
        summary = read_summary(found_run.folder)
        later: Sequence[DecisionFile] = ()
        if any(file.name.startswith("decision-") for file in found_run.files):
            from rigrunner.run.decisions import later_decisions  # noqa: PLC0415  (it loads the analysis; few runs need it)

            later = later_decisions(summary, found_run.folder)
        return _facts(found_run, summary, later)
    except RigrunnerError as error:
        return RunFacts(found_run, {"problem": storable(str(error))})


def _facts(found_run: FoundRun, summary: RunSummary, later: Sequence[DecisionFile]) -> RunFacts:
    document = summary.result_document
    # The run's own and all later ones; the last one is in force.
    records = [*_own(summary), *_later(later, summary)]
    decisions = [
        {**entry, "number": number, "in_force": number == len(records)}
        for number, entry in enumerate(records, 1)
    ]
    binding = later[-1].document["decision"] if later else at(document, "decision")
    in_force = decisions[-1] if decisions else {}
    inputs = {key(name): text(value) for name, value in summary.inputs.items()}
    run = {
        "problem": "",
        **_identity(summary),
        **headline(document),
        **{name: in_force.get(name) for name in _DECISION_COLUMNS},
        "bytes": sum(file.bytes for file in found_run.files),
    }
    parts = {
        "points": points(document),
        "results": named_results(document, binding),
        "coordinates": coordinates(document),
        "figures": figures(document, summary.zeros),
        "inputs": [{"name": name, "value": value} for name, value in inputs.items()],
        "decisions": decisions,
        "files": [
            {
                "name": storable(file.name),
                "bytes": file.bytes,
                "modified_ns": min(file.modified_ns, _LATEST_NS),
                "sha256": "" if file.name == RUN_FILE else _sha256(found_run.folder / file.name),
            }
            for file in found_run.files
        ],
    }
    return RunFacts(found_run, run, parts)


def _identity(summary: RunSummary) -> dict[str, Any]:
    inputs = {**summary.people, **summary.inputs}
    return {
        "run_id": key(summary.run_id),
        "started_utc": moment(summary.started_utc),
        "ended_utc": moment(summary.ended_utc),
        "sealed": summary.sealed,
        "outcome": text(summary.outcome),
        "reason": text(summary.reason),
        "procedure": key(summary.procedure_id),
        "revision": text(summary.procedure_revision),
        "title": text(summary.procedure_title),
        "rig": key(summary.station_id),
        **{name: key(inputs.get(name)) for name in NAMED_INPUTS},
        "approval": text(summary.approval.get("state")),
        "imported": bool(summary.imported),
        "replayed": REPLAYED in summary.provenance,
        "simulated": is_simulated(summary.provenance),
        "program": text(summary.provenance.get("Rigrunner")),
        "recordings": summary.recordings,
        "digest_sha256": digest(summary.digest),
        "manifest_sha256": digest(summary.manifest_sha256),
    }


def _own(summary: RunSummary) -> Iterator[Row]:
    """Yield the run's own decision. With limits on measured values its verdict covers both."""
    document = summary.result_document
    own_decision, verdict = at(document, "decision"), at(document, "verdict")
    if own_decision is not None or verdict is not None:
        decided_utc = moment(summary.ended_utc)
        overall = {n: text(at(verdict, n)) for n in ("verdict", "reason")} if verdict else {}
        yield {
            **decision(own_decision),
            **overall,
            "file": RUN_FILE,
            "decided_utc": decided_utc,
            "by": None,
            "why": None,
        }


def _later(later: Sequence[DecisionFile], summary: RunSummary) -> Iterator[Row]:
    # Measured values out of their limits: no decision on the results alters that.
    limits_failed = at(summary.result_document, "limits", "verdict") == Verdict.FAIL
    for decision_file in later:
        columns = decision(decision_file.document["decision"])
        yield {
            **columns,
            "verdict": str(Verdict.FAIL) if limits_failed else columns["verdict"],
            "file": text(decision_file.path.name),
            "decided_utc": moment(decision_file.document["decided_utc"]),
            "by": text(decision_file.document["by"]),
            "why": text(decision_file.document["reason"]),
        }


def _sha256(path: Path) -> str:
    """Return the digest of a file beside the run file, which has its manifest."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror}") from error
