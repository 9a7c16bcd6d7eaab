"""Issue the certificate of a stored run: JSON, and every printed form that can be made here."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from datetime import date, datetime, timedelta
from typing import TYPE_CHECKING

from rigrunner.api.certificate import FurtherCopy
from rigrunner.api.errors import UsageError
from rigrunner.api.progress import unseen
from rigrunner.certificate.content import (
    Issue,
    Source,
    certifiable,
    make_certificate,
    restrictions_of,
)
from rigrunner.certificate.letterhead import read_letterhead
from rigrunner.certificate.numbers import Numbers
from rigrunner.certificate.order import complete
from rigrunner.certificate.validity import not_calibrated
from rigrunner.clock import utc_text
from rigrunner.documents.certifying.derived_again import refuse_other_numbers
from rigrunner.documents.certifying.office import Issued, Office
from rigrunner.run.decision_records import record_of
from rigrunner.run.decisions import later_decisions
from rigrunner.run.locate import RUN_FILE
from rigrunner.run.provenance import is_simulated, layouts, software
from rigrunner.run.stored import analyse_stored
from rigrunner.runfile import read_with_truth

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.api.certificate import Authorisation, Certificate
    from rigrunner.api.letterhead import Letterhead
    from rigrunner.api.progress import Progress
    from rigrunner.certificate.order import Order
    from rigrunner.registry import Registry

_REASONS = {
    "draft_procedure": "its procedure was not approved",
    "simulated": "its data are simulated",
    "trial": "its instruments are those of a trial",
    "replayed": "it is the replay of a tape",
    "inconclusive_check": "a check says that nothing can be decided on it",
}


@dataclass(frozen=True, kw_only=True)
class Request:
    """The request to certify."""

    letterhead: Path
    """The laboratory's folder, which holds the sequence of numbers."""
    order: Order
    authorisation: Authorisation
    not_for_certification: bool = False
    language: str = ""
    out: Path | None = None
    """The folder to write into; None for that of the run."""
    order_fields: Mapping[str, object] = field(default_factory=dict)
    """Fields of the order that take precedence over the stored ones."""
    further_copy: str = ""
    """The reason for a further certificate for a run that has one."""


def certify(
    run: Path,
    request: Request,
    registry: Registry,
    now: datetime,
    *,
    progress: Progress = unseen,
) -> Issued:
    """Issue a certificate for a stored run; `progress` gets the forms made so far and their number.

    A number is taken only after all requirements are checked. Raises UsageError if something is
    missing or out of range, and DataError if the run allows no certificate.
    """
    letterhead = read_letterhead(request.letterhead, request.language)
    progress("reading and analysing the run", 1, 2)
    source = read_source(run, registry)
    progress("reading and analysing the run", 2, 2)
    certifiable(source)
    refuse_other_numbers(source.stored, source.result)
    restrictions = tuple(restrictions_of(source, requested=request.not_for_certification))
    run_id = source.stored.header.run_id
    if restrictions and not request.not_for_certification:
        reasons = " and ".join(dict.fromkeys(_REASONS[each.code] for each in restrictions))
        raise UsageError(
            f"{run_id} cannot be certified: {reasons}",
            hint="--not-for-certification makes a specimen that says so on every page",
            field="not_for_certification",
        )
    answers = {**source.stored.header.inputs, **source.result.run.people}
    order = complete(request.order, request.order_fields, answers)
    if order.received is not None:
        refuse_late_receipt(order.received, source.stored.header.started_utc)
    further = _further_copy(source, letterhead, request, is_specimen=bool(restrictions))
    if not restrictions:  # a simulator's time runs ahead of the clock
        _refuse_early_issue(source, now)
        _refuse_beyond_calibration(source)

    def content(number: str) -> Certificate:
        issue = Issue(
            number=number,
            issued_utc=utc_text(now),
            authorisation=request.authorisation,
            restrictions=restrictions,
            further_copy=further,
            software=software(registry),
            layouts=layouts(registry),
        )
        return make_certificate(source, order, letterhead, issue)

    folder = run if run.is_dir() else run.parent
    office = Office(request.letterhead, letterhead, registry, now, progress)
    issued = office.issue(content, request.out or folder, is_specimen=bool(restrictions))
    if not source.decided_again:
        return issued
    last = source.decided_again[-1]
    note = (
        f"the certificate states '{last.verdict}' by {last.file}, decided again by {last.by}:"
        f" {last.reason} (until then '{last.verdict_before}')"
    )
    return replace(issued, notes=(*issued.notes, note))


def read_source(run: Path, registry: Registry) -> Source:
    """Read and analyse a stored run, by the decision in force; raise DataError."""
    stored, truth = read_with_truth(run)
    file = run / RUN_FILE if run.is_dir() else run
    later = later_decisions(stored, file.parent)
    acceptance = later[-1].acceptance if later else None
    return Source(
        stored=stored,
        result=analyse_stored(stored, registry, acceptance=acceptance),
        file_sha256=hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else "",
        simulated=bool(truth) or is_simulated(stored.header.provenance),
        decided_again=tuple(map(record_of, later)),
    )


def _refuse_early_issue(source: Source, now: datetime) -> None:
    """Refuse a certificate that would be dated before its test: a clock is wrong."""
    ended = source.result.run.ended_utc
    if now < datetime.fromisoformat(ended):
        raise UsageError(
            f"the run ended on {ended[:19]}, and it is {utc_text(now)[:19]} (UTC): a certificate"
            " cannot be dated before its test",
            hint="correct the wrong clock; if it was that of the rig, repeat the run",
        )


def _further_copy(
    source: Source, letterhead: Letterhead, request: Request, *, is_specimen: bool
) -> FurtherCopy | None:
    """Return the note of a further certificate on the first one; raise if no reason is given.

    Otherwise a second certificate for a run is refused: a new one must name what it replaces
    (7.8.8.3).
    """
    run_id, reason = source.stored.header.run_id, request.further_copy.strip()
    numbers = Numbers.of(request.letterhead, letterhead, is_specimen=is_specimen)
    number = numbers.in_force_for(run_id)
    if not number:
        if withdrawn := numbers.withdrawn_for(run_id):
            raise UsageError(
                f"{withdrawn} was issued on {run_id}, and {numbers.withdrawal_of(withdrawn)}",
                hint=f"'rigrunner amend' replaces {withdrawn}, and the further document says so",
            )
        if reason:
            raise UsageError(
                f"nothing was issued on {run_id} yet, so this is not a further copy",
                hint="leave --further-copy out",
                field="further_copy",
            )
        return None
    if not is_specimen:
        raise UsageError(
            f"{number} was already issued on {run_id}, and is in force",
            hint=f"'rigrunner amend' replaces {number}, and the further document says so",
        )
    if not reason:
        raise UsageError(
            f"{number} exists: it was issued on {run_id} and is in force",
            hint="amend it ('rigrunner amend'), or issue a further copy, with a reason"
            " (--further-copy REASON)",
            field="further_copy",
        )
    return FurtherCopy(number=number, reason=reason, by=request.authorisation.by)


def _refuse_beyond_calibration(source: Source) -> None:
    """Refuse a certificate on values that are out of the calibrated range."""
    run_id = source.stored.header.run_id
    for problem in not_calibrated(source.result):
        if problem.kind != "range":
            raise UsageError(
                f"{run_id} cannot be certified: {problem.where}: {problem.text}",
                hint="enter the instrument with its certificate and accuracy in the station's"
                " register, and repeat the run",
            )
        beyond = f"{problem.where} exceeded its calibrated range: {problem.text}"
        raise UsageError(
            f"{run_id} cannot be certified: {beyond}",
            hint="have it calibrated up to there, or repeat the run within the range;"
            " --not-for-certification makes a specimen that says so",
        )


def refuse_late_receipt(received: date, started_utc: str) -> None:
    """Raise UsageError for receipt after the test. The date is local, and may be ahead of UTC."""
    started = date.fromisoformat(started_utc[:10])
    if received > started + timedelta(days=1):
        raise UsageError(
            f"--received {received} is after the test, which began on {started} (UTC)",
            field="received",
        )
