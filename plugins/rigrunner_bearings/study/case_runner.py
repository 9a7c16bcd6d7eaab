"""Runs the cases of a study: with workers, progress, and a journal of the findings."""

from __future__ import annotations

import json
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from pydantic import TypeAdapter

from rigrunner.api import DataError
from rigrunner.api.errors import AbortedError
from rigrunner.jobs import journal
from rigrunner.run.provenance import code_digest, refuse_other_software, software
from rigrunner_bearings.study.tools import tools

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from _typeshed import DataclassInstance

    from rigrunner.api import StopToken
    from rigrunner.jobs import Journal, Workers
    from rigrunner_bearings.study.case import Case

Finding = TypeVar("Finding", bound="DataclassInstance")


@dataclass(frozen=True)
class CaseRunner:
    """Runs the cases of one study."""

    workers: Workers
    stop: StopToken
    progress: Callable[[int, int], None]
    """Gets the number of finished cases and of all; those of the journal count as finished."""
    journal_path: Path | None = None
    """The journal of findings, from which the same study continues; None for no journal."""

    def findings(
        self,
        study: str,
        examine: Callable[[Case], Finding],
        kind: type[Finding],
        cases: Sequence[Case],
    ) -> list[Finding]:
        """Return the finding of every case, in order, whichever worker examined it.

        `examine` is a function of a module, and its finding, a dataclass of that kind, follows from
        the case alone. Raises AbortedError once the token is set.
        """
        parse = TypeAdapter(kind).validate_python
        keys = [json.dumps(asdict(case), sort_keys=True) for case in cases]
        findings: dict[str, Finding] = {}
        # A finding depends on more than its case: other software has other findings.
        opened: AbstractContextManager[Journal | None] = nullcontext()
        if self.journal_path is not None:
            header = {"study": study, **software(tools().registry), "code": code_digest()}
            opened = journal(self.journal_path, header)
        with opened as stored:
            if stored is not None:
                findings |= {key: parse(stored[key]) for key in keys if key in stored}
            remaining = [place for place, key in enumerate(keys) if key not in findings]
            self.progress(len(findings), len(keys))
            task = _Examination(examine, software(tools().registry))
            for done in self.workers.outcomes(task, [cases[i] for i in remaining], self.stop):
                key, value = keys[remaining[done.place]], done.answer.value
                if value is None:
                    if done.answer.trace:
                        raise RuntimeError(f"{done.item}:\n{done.answer.trace}")
                    raise DataError(f"{done.item}: {done.problem}")
                findings[key] = value
                if stored is not None:
                    stored.add(key, asdict(value))
                self.progress(len(findings), len(keys))
        if len(findings) < len(set(keys)):
            hint = f"they are kept in {self.journal_path}: the same command continues"
            raise AbortedError(
                f"the study was stopped after {len(findings)} of {len(keys)} rigs",
                hint=hint if stored else "",
            )
        return [findings[key] for key in keys]


@dataclass(frozen=True)
class _Examination(Generic[Finding]):
    """Examines a case by this software and no other."""

    examine: Callable[[Case], Finding]
    software: Mapping[str, str]

    def __call__(self, case: Case) -> Finding:
        refuse_other_software(self.software, tools().registry)
        return self.examine(case)
