"""Later decisions on a stored run, by another rule or other limits, each in its own file.

`run.h5` is not changed. `decision-2.json`, `decision-3.json` and so on beside it record who decided
what, when and why, by which rules before and after, and on which recordings, by digest.
"""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner import __version__
from rigrunner.analysis.verdict.document import decision as decision_document
from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.events import Outcome
from rigrunner.api.verdict import LaterDecision, Verdict
from rigrunner.clock import utc_text
from rigrunner.procedure import Acceptance, kinds_of, parse_procedure
from rigrunner.procedure.kinds import STORED
from rigrunner.run.locate import RUN_FILE
from rigrunner.run.stored import analyse_stored
from rigrunner.runfile import read
from rigrunner.runfile.durable import sync_file, sync_folder, writing
from rigrunner.yamlfile.upgrade import upgraded_acceptance

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.results import Result
    from rigrunner.procedure import Procedure
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun

FORMAT = "rigrunner: decision/1"
FIRST = 2
"""The run's own decision is the first."""
NAME = re.compile(r"decision-([1-9]\d{0,5})\.json")
NONE = "none"


@dataclass(frozen=True, kw_only=True)
class Decider:
    """Who decides again, why, and when."""

    by: str
    reason: str
    at: datetime


@dataclass(frozen=True, eq=False)
class DecisionFile:
    """A later decision and its file."""

    path: Path
    document: Mapping[str, Any]
    acceptance: Acceptance
    sha256: str
    """Of the bytes of the file."""

    @property
    def summary(self) -> LaterDecision:
        """The decision for a report."""
        decision, before = self.document["decision"], self.document["before"]
        return LaterDecision(
            file=self.path.name,
            decided_utc=self.document["decided_utc"],
            by=self.document["by"],
            why=self.document["reason"],
            verdict=decision["verdict"],
            reason=decision["reason"],
            rule=decision["rule"],
            limit_text=decision["limit"],
            limit_source=decision["limit_source"],
            verdict_before=before["verdict"],
            rule_before=before["rule"],
            limit_before=before["limit"],
        )


class Digested(Protocol):
    """Has the digest of the recordings of a run."""

    @property
    def digest(self) -> str:
        """SHA-256 of recordings and measurements."""


def later_decisions(stored: Digested, folder: Path) -> tuple[DecisionFile, ...]:
    """Return the decisions beside a run, oldest first.

    Raises DataError for an unreadable file, for one on other recordings, and for a missing one.
    """
    decisions = tuple(_read(path, stored.digest) for _, path in _files(folder))
    previous = RUN_FILE
    for number, decision in enumerate(decisions, FIRST):
        if decision.path.name != _name(number) or decision.document["before"]["file"] != previous:
            raise DataError(
                f"{decision.path} does not follow {previous}: it was decided after "
                f"{decision.document['before']['file']}",
                hint=f"bring back {_name(number)}: a recorded decision must stay",
            )
        previous = decision.path.name
    return decisions


def acceptance_in_force(stored: StoredRun, folder: Path) -> Acceptance | None:
    """Return limits and rule of the latest decision, by default those of the procedure."""
    later = later_decisions(stored, folder)
    return later[-1].acceptance if later else _procedure(stored).acceptance


def decide_again(
    folder: Path,
    registry: Registry,
    decider: Decider,
    change: Callable[[Acceptance | None, Sequence[str]], Acceptance],
) -> tuple[DecisionFile, Result]:
    """Decide on a stored run by other limits or another rule, and record that.

    `change` returns the new limits and rule from the present ones and the names of the analyses of
    the run. Nothing is measured again, and no existing file is changed. Raises UsageError if name
    or reason are missing or nothing changes, and DataError for a run without anything to decide, or
    limits for other results.
    """
    if not (decider.by.strip() and decider.reason.strip()):
        raise UsageError("a decision needs a name and a reason", hint="give --by and --reason")
    stored = read(folder)
    if stored.info.outcome != Outcome.COMPLETED:
        raise DataError(
            f"{stored.header.run_id} was not completed ({stored.info.outcome})",
            hint="a run that was not completed neither passes nor fails",
        )
    before = acceptance_in_force(stored, folder)
    analyses = _procedure(stored).analysis
    names = [analysis.name for analysis in analyses]
    after = change(before, names).as_read_by(kinds_of(registry), analyses)
    if before is not None and after.as_written() == before.as_written():
        raise UsageError(
            "these limits and this rule are already in force", hint="nothing was written"
        )
    result = analyse_stored(stored, registry, acceptance=after)
    _refuse(result, after)
    _refuse_other_results(result, after, names)
    assert result.decision is not None  # noqa: S101  (an acceptance was given)
    content = {
        "format": FORMAT,
        "run": {"id": stored.header.run_id, "digest_sha256": stored.digest},
        "decided_utc": utc_text(decider.at),
        "by": decider.by,
        "reason": decider.reason,
        "program": f"Rigrunner {__version__}",
        "before": _in_force(folder, stored, before),
        "acceptance": after.as_written(),
        "decision": decision_document(result.decision),
    }
    return _read(_write(folder, content), stored.digest), result


def _procedure(stored: StoredRun) -> Procedure:
    header = stored.header
    return parse_procedure(header.procedure_text, header.procedure_id, stored=True).model


def _refuse(result: Result, acceptance: Acceptance) -> None:
    """Raise DataError if there is no result, or a limit is for another measurand."""
    entries = (*result.results, *result.missing, *result.means)
    run_id, names = result.run.run_id, {entry.name for entry in entries}
    if not names:
        why = f": {result.notes[0]}" if result.notes else ""
        raise DataError(
            f"{run_id} has no result to decide on{why}",
            hint="" if why else f"the analyses of {result.run.procedure_id} name none",
        )
    for details in result.details:
        for limit in acceptance.limits:
            if limit.of not in details.shown_results & names:
                continue
            if objection := details.objection(limit.measurand):
                hint = "a limit applies only to results of the same measurand"
                text = f"{objection[:1].lower()}{objection[1:]}".rstrip(".")
                raise DataError(f"{limit.source}: {text}", hint=hint)


def _refuse_other_results(result: Result, acceptance: Acceptance, analyses: Sequence[str]) -> None:
    """Raise DataError for a limit of a result that the run does not have, or of another kind."""
    entries = (*result.results, *result.missing, *result.means)
    definitions = {entry.name: entry.of for entry in entries}
    for limit in acceptance.limits:
        if limit.of not in definitions:
            names = ", ".join(definitions)
            raise DataError(
                f"{result.run.run_id} has no result '{limit.of}'", hint=f"results: {names}"
            )
        definition = definitions[limit.of]
        for _, message, hint in limit.misfits(definition):
            raise DataError(f"{limit.source}: {message}", hint=hint)
        message, hint = limit.objection_to(definition, analyses)
        if message:
            raise DataError(f"{limit.source}: {message}", hint=hint)


def _in_force(folder: Path, stored: StoredRun, acceptance: Acceptance | None) -> dict[str, Any]:
    """Return the present decision and its file."""
    later = later_decisions(stored, folder)
    document: Mapping[str, Any] = stored.result_document or {}
    decision = later[-1].document["decision"] if later else document.get("decision")
    summary = decision or {"verdict": NONE, "rule": NONE, "limit": NONE}
    return {
        "file": later[-1].path.name if later else RUN_FILE,
        "acceptance": None if acceptance is None else acceptance.as_written(),
        **{key: summary[key] for key in ("verdict", "rule", "limit")},
    }


def _write(folder: Path, content: Mapping[str, Any]) -> Path:
    """Write the next decision file durably; never overwrite one."""
    text = json.dumps(content, ensure_ascii=False, indent=2, allow_nan=False)
    number = max((number for number, _ in _files(folder)), default=FIRST - 1) + 1
    path = folder / _name(number)
    with writing(path):
        # "x": a decision that another process has just written is not overwritten.
        with path.open("x", encoding="utf-8") as file:
            file.write(f"{text}\n")
        sync_file(path)
        sync_folder(folder)
    return path


def _name(number: int) -> str:
    return f"decision-{number}.json"


def _files(folder: Path) -> list[tuple[int, Path]]:
    matches = [(NAME.fullmatch(path.name), path) for path in folder.iterdir()]
    return sorted((int(match[1]), path) for match, path in matches if match)


def _read(path: Path, digest: str) -> DecisionFile:
    try:
        content = path.read_bytes()
        document = json.loads(content)
        # The decision may have been written in an earlier language of procedures.
        upgraded = upgraded_acceptance(document["acceptance"])
        acceptance = Acceptance.model_validate(upgraded, context={STORED: True})
        file = DecisionFile(path, document, acceptance, hashlib.sha256(content).hexdigest())
        recordings, kind = document["run"]["digest_sha256"], document["format"]
        texts = vars(file.summary).values()
        # Raises ValueError for an unknown verdict.
        Verdict(file.summary.verdict)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise _unreadable(path) from error
    if kind != FORMAT or not all(isinstance(text, str) for text in texts):
        raise _unreadable(path)
    if recordings != digest:
        raise DataError(
            f"{path} is a decision on other recordings: it names {recordings[:16]}…, these are "
            f"{digest[:16]}…",
            hint="move it to the run that it belongs to",
        )
    return file


def _unreadable(path: Path) -> DataError:
    hint = "move it away to continue without it; a recorded decision is never deleted"
    return DataError(f"{path} is not a decision that can be read", hint=hint)
