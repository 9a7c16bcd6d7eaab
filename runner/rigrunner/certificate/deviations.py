"""Everything in which a run was not as its procedure says, from the record and from people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from rigrunner.api.analysis import SwingPoint
from rigrunner.api.certificate import Deviation, RejectedCycle
from rigrunner.api.checks import effect_words
from rigrunner.api.events import (
    Alarm,
    Intervention,
    LimitMissed,
    Note,
    Outcome,
    StepEnded,
)
from rigrunner.certificate.numerals import finite, printed
from rigrunner.certificate.validity import beyond_calibration, load_channel, load_problem

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.analysis import Check, PeakPoint, Rejection
    from rigrunner.api.certificate import Condition, InstrumentEntry
    from rigrunner.api.events import Event
    from rigrunner.api.results import Result
    from rigrunner.certificate.order import Order
    from rigrunner.runfile import StoredRun

OVERRIDE = "override"
AMBIENT = {"temperature", "humidity"}
"""What is read of the surroundings."""
_STATISTIC_DECIMALS = 3


def deviations_of(
    stored: StoredRun,
    result: Result,
    order: Order,
    instruments: Sequence[InstrumentEntry],
    conditions: Sequence[Condition],
) -> Iterator[Deviation]:
    """Yield all deviations, those of the no-load run included, and what a person states."""
    run_id = stored.header.run_id
    for each in (stored, stored.no_load, stored.no_load_after):
        if each is not None:
            yield from _of_run(each)
    yield from _of_instruments(run_id, result, instruments)
    if not (order.conditions or any(each.quantity in AMBIENT for each in conditions)):
        yield Deviation(kind="conditions", run_id=run_id, text="")
    for check in checks_of(result):
        if not check.ok or check.consequence:
            words = (check.text, effect_words(check), check.advice)
            yield Deviation(
                kind="remark" if check.ok else "failed_check",
                run_id=run_id,
                where=check.name,
                text="; ".join(each for each in words if each),
            )
    for text in result.notes:
        yield Deviation(kind="remark", run_id=run_id, text=text)
    for text in order.deviations:
        yield Deviation(kind="stated", run_id=run_id, text=text)


def rejected_of(result: Result) -> Iterator[RejectedCycle]:
    """Yield every cycle that a rule for gross errors left out, of both runs."""
    for run, points in ((result.run, result.loaded), (result.no_load_run, result.no_load)):
        if run is not None:
            for point in points:
                yield from _rejected(run.run_id, point)


def _of_instruments(
    run_id: str, result: Result, instruments: Sequence[InstrumentEntry]
) -> Iterator[Deviation]:
    for entry in instruments:
        if entry.overdue:
            text = f"{entry.serial}: due {entry.due}"
            yield Deviation(kind="calibration", run_id=run_id, where=entry.channel, text=text)
    for channel, text in beyond_calibration(result):
        yield Deviation(kind="range", run_id=run_id, where=channel, text=text)
    if text := load_problem(result):
        yield Deviation(kind="load", run_id=run_id, where=load_channel(result), text=text)


def _of_run(run: StoredRun) -> Iterator[Deviation]:
    run_id = run.header.run_id
    yield from _recorded(run_id, run.events)
    for former in run.superseded:
        utc = former.started_utc
        yield Deviation(kind="repeated", run_id=run_id, where=former.name, text="", utc=utc)
    for row in run.superseded_measurements:
        yield Deviation(kind="repeated", run_id=run_id, where=row.name, text="", utc=row.utc)
    if run.info.outcome == Outcome.STOPPED_AT_LIMIT:
        text = f"Stopped at a limit: {run.info.reason}. What follows in the procedure was not done."
        yield Deviation(kind="remark", run_id=run_id, text=text, utc=run.info.ended_utc)
    for text in run.notes:
        yield Deviation(kind="remark", run_id=run_id, text=text)


def _recorded(run_id: str, events: Sequence[Event]) -> Iterator[Deviation]:
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
                pass  # it is a result
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


def checks_of(result: Result) -> Iterator[Check]:
    """Yield the checks of both runs and of the primary method."""
    yield from result.checks
    primary = result.compensations.get(result.primary)
    if primary is not None:
        yield from primary.checks


def _rejected(run_id: str, point: PeakPoint) -> Iterator[RejectedCycle]:
    for each in point.peak_rejections:
        yield _cycle(run_id, point.recording, "peak", each)
    if isinstance(point, SwingPoint):
        for each in point.waveform_rejections:
            yield _cycle(run_id, point.recording, "waveform", each)


def _cycle(
    run_id: str, recording: str, what: Literal["peak", "waveform"], each: Rejection
) -> RejectedCycle:
    return RejectedCycle(
        run_id=run_id,
        recording=recording,
        cycle=each.index + 1,
        what=what,
        rule=each.rule,
        value_nm=finite(each.value),
        statistic=finite(each.statistic),
        critical=finite(each.critical),
        printed_statistic=printed(each.statistic, _STATISTIC_DECIMALS),
        printed_critical=printed(each.critical, _STATISTIC_DECIMALS),
    )
