"""How the cases of a study are gone through: by whom, how far it is, and where what is done is."""

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
class Going:
    """Goes through the cases of one study."""

    workers: Workers
    stop: StopToken
    progress: Callable[[int, int], None]
    """Is told how many of how many are done, first those that were done before."""
    keep: Path | None = None
    """The journal of what is done, from which the same study goes on; None keeps nothing."""

    def findings(
        self,
        study: str,
        examine: Callable[[Case], Finding],
        kind: type[Finding],
        wanted: Sequence[Case],
    ) -> list[Finding]:
        """Return the finding of every case, in order, whoever did it.

        `examine` is a function of a module, and its finding, a dataclass of that kind, follows from
        the case alone. Raises AbortedError once the token is set.
        """
        read = TypeAdapter(kind).validate_python
        keys = [json.dumps(asdict(case), sort_keys=True) for case in wanted]
        found: dict[str, Finding] = {}
        # A finding depends on more than its case: other programs find other things.
        keeping: AbstractContextManager[Journal | None] = (
            nullcontext()
            if self.keep is None
            else journal(
                self.keep,
                {"study": study, **software(tools().registry), "code": code_digest()},
            )
        )
        with keeping as kept:
            found |= {key: read(kept[key]) for key in keys if kept is not None and key in kept}
            left = [place for place, key in enumerate(keys) if key not in found]
            self.progress(len(found), len(keys))
            task = _Examination(examine, software(tools().registry))
            for done in self.workers.outcomes(task, [wanted[i] for i in left], self.stop):
                key, value = keys[left[done.place]], done.answer.value
                if value is None:
                    if done.answer.trace:
                        raise RuntimeError(f"{done.item}:\n{done.answer.trace}")
                    raise DataError(f"{done.item}: {done.problem}")
                found[key] = value
                if kept is not None:
                    kept.add(key, asdict(value))
                self.progress(len(found), len(keys))
        if len(found) < len(set(keys)):
            raise AbortedError(
                f"the study was stopped after {len(found)} of {len(keys)} rigs",
                hint=f"they are kept in {self.keep}: the same command continues" if kept else "",
            )
        return [found[key] for key in keys]


@dataclass(frozen=True)
class _Examination(Generic[Finding]):
    """Examines a case by this software and no other."""

    examine: Callable[[Case], Finding]
    software: Mapping[str, str]

    def __call__(self, case: Case) -> Finding:
        refuse_other_software(self.software, tools().registry)
        return self.examine(case)
