"""Record points manually: a run of its own kind, analysed as the procedure's would be."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.progress import unseen
from rigrunner.engine import run_by_hand
from rigrunner.plan import Plan
from rigrunner.procedure import parse_procedure
from rigrunner.run.approval import ApprovalState
from rigrunner.run.left_energised import NOBODY
from rigrunner.run.overrides import require_overridden
from rigrunner.run.record import into_folder, new_folder

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.devices import StopToken
    from rigrunner.api.events import EventSink
    from rigrunner.bus import Bus
    from rigrunner.engine import Interference, Override, Pauses, RunSummary
    from rigrunner.engine.session import Session
    from rigrunner.plan.actions import PlannedStep
    from rigrunner.rig import Rig
    from rigrunner.run.finish import FinishedRun
    from rigrunner.run.left_energised import Person
    from rigrunner.run.prepare import Planned

SUFFIX = "-by-hand"
_COPIED_KEYS = ("measurand", "uses", "analysis")
NOTE = "recorded by hand"


def record_by_hand(
    planned: Planned,
    steps: Callable[[Session], Iterator[PlannedStep]],
    *,
    runs: Path,
    partners: Mapping[str, Path],
    stop: StopToken,
    pauses: Pauses,
    listeners: Sequence[EventSink] = (),
    operator: str = "",
    overrides: Sequence[Override] = (),
    person: Person = NOBODY,
) -> FinishedRun:
    """Connect the rig, execute the steps as they come, seal the folder and write the report.

    The run file has a procedure without steps and limits, marked as manual, and is never one for
    certification. Raises as `rigrunner.run.record.execute`.
    """
    require_overridden(planned, overrides)
    manual = by_hand(planned)
    people = {"operator": operator} if operator else {}

    def work(rig: Rig, bus: Bus, folder: Path, before: Sequence[Interference]) -> RunSummary:
        return run_by_hand(
            steps,
            rig,
            bus,
            manual.clock,
            stop,
            folder.name,
            overrides,
            interlocks=planned.plan.interlocks,
            pauses=pauses,
            before=before,
        )

    return into_folder(
        manual,
        lambda identified: new_folder(manual, runs, {}, people, identified, partners),
        work,
        inputs={},
        partners=partners,
        listeners=listeners,
        progress=unseen,
        person=person,
    )


def by_hand(planned: Planned) -> Planned:
    """Return the plan as a procedure of its own, with a note in place of its steps."""
    model, data = planned.procedure.model, planned.procedure.document.data
    content = {
        "rigrunner": "procedure/2",
        "id": f"{model.id}{SUFFIX}",
        "revision": model.revision,
        "title": f"{model.title}: by hand",
        **{key: data[key] for key in _COPIED_KEYS if key in data},
        "main": [{"note": {"text": f"{NOTE}, after {model.id} revision {model.revision}"}}],
    }
    text = json.dumps(content, ensure_ascii=False, indent=1)
    procedure = parse_procedure(text, content["id"])
    note = "points recorded by hand follow no procedure"
    state = ApprovalState("draft", sha256=procedure.digest_with_called, note=note)
    plan = Plan((), planned.plan.interlocks)
    return replace(planned, procedure=procedure, plan=plan, approval=state)
