"""Preflight: checks everything that a run needs, with the rig connected, before anything moves."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

from rigrunner.api.analysis.requirements import partner_words
from rigrunner.api.errors import RigrunnerError
from rigrunner.run.partners import each_partner
from rigrunner.run.planning import planned_run
from rigrunner.run.rig_lock import rig_lock
from rigrunner_panel.jobs.preflight_calibrations import calibrations
from rigrunner_panel.jobs.preflight_rig import rig_items, unconfirmed_item
from rigrunner_panel.process.messages import Ended
from rigrunner_panel.view.sections import Preflight, PreflightItem

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.run.prepare import Planned
    from rigrunner_panel.process.link import Link
    from rigrunner_panel.process.messages import Job

_GB = 1e9
_TWICE = 2
"""Factor for disk space: the journal and the finished file exist at the same time."""
_PLENTY_BYTES = 1e9


def preflight(job: Job, link: Link) -> Ended:
    """Report each check to the panel when it is done; raise the errors of invalid files."""
    planned = planned_run(job.procedure, job.station, realtime=True)
    items: tuple[PreflightItem, ...] = ()
    for item in _items(planned, job):
        items += (item,)
        link.show(preflight=Preflight.of(job.view, items))
        if link.switch.is_set():
            raise link.switch.reason()
    return Ended()


def _items(planned: Planned, job: Job) -> Iterator[PreflightItem]:
    yield _approval(planned)
    yield from _partners(planned, job)
    yield from calibrations(planned)
    yield _disk(planned, job.runs)
    try:
        with rig_lock(planned) as marks:
            yield from rig_items(planned, marks)
            if marks is not None and marks.unconfirmed:
                yield unconfirmed_item(marks, planned.station.document.name, job)
    except RigrunnerError as error:
        yield PreflightItem(
            kind="device", name="rig", state="fail", text=error.message, fix=error.hint
        )


def _approval(planned: Planned) -> PreflightItem:
    model = planned.procedure.model
    return PreflightItem(
        kind="procedure",
        name=model.id,
        state="warn" if planned.approval.is_draft else "ok",
        text=f"revision {model.revision}: {planned.approval.sentence()}",
        fix="'rigrunner approve' approves a procedure" if planned.approval.is_draft else "",
    )


def _partners(planned: Planned, job: Job) -> Iterator[PreflightItem]:
    for name, result in each_partner(planned, job.runs, job.partners):
        words = partner_words(name)
        if isinstance(result, RigrunnerError):
            yield PreflightItem(
                kind="partner", name=words, state="fail", text=result.message, fix=result.hint
            )
        else:
            yield PreflightItem(kind="partner", name=words, state="ok", text=result.name)


def _disk(planned: Planned, runs: Path) -> PreflightItem:
    free, need = free_bytes(runs), needed_bytes(planned)
    text = f"{_size(free)} free, the run needs {_size(need)}"
    if free < need:
        fix = f"free space on the disk of {runs.absolute()}, or choose another folder with --runs"
        return PreflightItem(
            kind="disk", name="disk", state="fail", text=text, fix=fix, override="disk"
        )
    short = free < need + _PLENTY_BYTES
    fix = "little space is left for the next run: free some" if short else ""
    state = "warn" if short else "ok"
    return PreflightItem(kind="disk", name="disk", state=state, text=text, fix=fix)


def _size(count: float) -> str:
    return f"{count / _GB:.1f} GB" if count >= _GB else f"{count / 1e6:.1f} MB"


def needed_bytes(planned: Planned) -> int:
    """Return the space on the disk that a run needs."""
    return _TWICE * planned.prediction().disk_bytes


def free_bytes(folder: Path) -> int:
    """Return the free space of a folder, or of the folder in which it would be created."""
    folders = (folder.absolute(), *folder.absolute().parents)
    existing = next(path for path in folders if path.exists())
    return shutil.disk_usage(existing).free
