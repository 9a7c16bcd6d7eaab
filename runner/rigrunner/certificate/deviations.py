"""Deviations of a run from its procedure, from the record and from people."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.certificate import Deviation
from rigrunner.api.checks import effect_words
from rigrunner.api.events import (
    Alarm,
    Intervention,
    LimitMissed,
    Note,
    Outcome,
    StepEnded,
)
from rigrunner.certificate.validity import not_calibrated

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.certificate import Condition, InstrumentEntry
    from rigrunner.api.events import Event
    from rigrunner.api.results import Result
    from rigrunner.certificate.order import Order
    from rigrunner.runfile import StoredRun

OVERRIDE = "override"
AMBIENT = {"temperature", "humidity"}
"""Ambient quantities."""


def deviations_of(
    stored: StoredRun,
    result: Result,
    order: Order,
    instruments: Sequence[InstrumentEntry],
    conditions: Sequence[Condition],
) -> Iterator[Deviation]:
    """Yield all deviations, including those of partner runs and those stated by people."""
    run_id = stored.header.run_id
    for run in (stored, *stored.partners.values()):
        yield from _of_run(run)
    for entry in instruments:
        if entry.overdue:
            text = f"{entry.serial}: due {entry.due}"
            yield Deviation(kind="calibration", run_id=run_id, where=entry.channel, text=text)
    beyond = tuple(not_calibrated(result))
    yield from beyond
    if not (order.conditions or any(condition.quantity in AMBIENT for condition in conditions)):
        yield Deviation(kind="conditions", run_id=run_id, text="")
    for check in result.every_check:
        if not check.ok or check.consequence:
            words = (check.text, effect_words(check), check.advice)
            yield Deviation(
                kind="remark" if check.ok else "failed_check",
                run_id=run_id,
                where=check.name,
                text="; ".join(part for part in words if part),
            )
    for text in result.notes:
        if any(deviation.where in text and deviation.text in text for deviation in beyond):
            continue
        yield Deviation(kind="remark", run_id=run_id, text=text)
    for text in order.deviations:
        yield Deviation(kind="stated", run_id=run_id, text=text)


def _of_run(run: StoredRun) -> Iterator[Deviation]:
    run_id = run.header.run_id
    yield from _of_events(run_id, run.events)
    for recording in run.superseded:
        utc = recording.started_utc
        yield Deviation(kind="repeated", run_id=run_id, where=recording.name, text="", utc=utc)
    for row in run.superseded_measurements:
        yield Deviation(kind="repeated", run_id=run_id, where=row.name, text="", utc=row.utc)
    if run.info.outcome == Outcome.STOPPED_AT_LIMIT:
        text = f"Stopped at a limit: {run.info.reason}. What follows in the procedure was not done."
        yield Deviation(kind="remark", run_id=run_id, text=text, utc=run.info.ended_utc)
    for text in run.notes:
        yield Deviation(kind="remark", run_id=run_id, text=text)


def _of_events(run_id: str, events: Sequence[Event]) -> Iterator[Deviation]:
    for event in events:
        match event:
            case Intervention():
                yield Deviation(
                    kind="override" if event.action == OVERRIDE else "intervention",
                    run_id=run_id,
                    where="" if event.action == OVERRIDE else event.action,
                    text=event.subject,
                    by=event.by,
                    reason=event.reason,
                    utc=event.utc,
                )
            case LimitMissed():
                pass  # a result; before Note, of which it is a subclass
            case Alarm():
                yield Deviation(
                    kind="alarm", run_id=run_id, where=event.source, text=event.text, utc=event.utc
                )
            case Note():
                yield Deviation(
                    kind="note", run_id=run_id, where=event.step, text=event.text, utc=event.utc
                )
            case StepEnded(ok=False):
                yield Deviation(
                    kind="failed_step",
                    run_id=run_id,
                    where=event.step,
                    text=event.recording or event.action,
                    utc=event.utc,
                )
            case _:
                pass
