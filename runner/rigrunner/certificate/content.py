"""The content of a certificate, from a stored run, its result, and what people state."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from itertools import chain
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Consequence
from rigrunner.api.certificate import (
    Amendment,
    Appearance,
    Approval,
    Authorisation,
    Certificate,
    Evidence,
    FurtherCopy,
    Method,
    Performance,
    Restriction,
    RunEvidence,
)
from rigrunner.api.errors import DataError
from rigrunner.api.events import Outcome
from rigrunner.api.partner_keys import KEYS
from rigrunner.api.results import REPLAYED
from rigrunner.certificate.deviations import deviations_of
from rigrunner.certificate.order import customer_of, external_of, item_of, opinions_of
from rigrunner.certificate.results import (
    certified_of,
    conformity_of,
    measured_of,
    models_of,
    named_of,
)
from rigrunner.certificate.surroundings import conditions_of, instruments_of
from rigrunner.certificate.validity import traceability_of
from rigrunner.signal.as_json.values import plain

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.certificate import CertifiedDetails, DecisionRecord
    from rigrunner.api.letterhead import Letterhead
    from rigrunner.api.results import Result
    from rigrunner.certificate.order import Order
    from rigrunner.runfile import StoredRun

REVISION = 4
"""Revision of the extraction from a run and its result; increased by each change of the content.

Revisions of methods have their own numbers.
"""
APPROVED, DRAFT = "approved", "draft"
_APPROVAL = tuple(Approval.model_fields)


@dataclass(frozen=True, kw_only=True)
class Source:
    """A stored run with its result: everything measured on a certificate."""

    stored: StoredRun
    result: Result
    file_sha256: str
    """Of `run.h5`."""
    simulated: bool
    """Whether the data are simulated."""
    decided_again: tuple[DecisionRecord, ...] = ()
    """Later decisions, oldest first; `result` has the latest."""


@dataclass(frozen=True, kw_only=True)
class Issue:
    """Issuer, date and number of a certificate."""

    number: str
    issued_utc: str
    authorisation: Authorisation
    restrictions: tuple[Restriction, ...]
    software: Mapping[str, str]
    amends: Amendment | None = None
    further_copy: FurtherCopy | None = None
    layouts: Mapping[str, int] = field(default_factory=dict)
    """Revision of the layout of each printed form, by name."""


def make_certificate(
    source: Source, order: Order, letterhead: Letterhead, issue: Issue
) -> Certificate:
    """Return the certificate; raise DataError if the run allows none (see `certifiable`)."""
    certifiable(source)
    run, result = source.stored, source.result
    parts = certified_of(result)
    runs = (result.run, *result.run.partners.values())
    instruments = tuple(instruments_of(*runs))
    conditions = tuple(conditions_of(result.run))
    return Certificate(
        number=issue.number,
        issued_utc=issue.issued_utc,
        restrictions=issue.restrictions,
        amends=issue.amends,
        further_copy=issue.further_copy,
        laboratory=letterhead.laboratory,
        customer=customer_of(order),
        item=item_of(order),
        method=_method(run, result, parts),
        performance=Performance(
            started_utc=result.run.started_utc,
            ended_utc=result.run.ended_utc,
            station=result.run.station_id,
            mandrel=result.run.mandrel,
            operator=order.operator,
            inputs=dict(result.run.inputs),
        ),
        conditions=conditions,
        conditions_stated=order.conditions,
        results=next((part.results for part in parts if part.results), None),
        named=named_of(result),
        models=tuple(models_of(result)),
        validity=tuple(chain.from_iterable(part.validity for part in parts)),
        traceability=traceability_of(result, instruments),
        conformity=conformity_of(result.decision, source.decided_again),
        measured=measured_of(result),
        opinions=opinions_of(order),
        external=external_of(order),
        deviations=tuple(deviations_of(run, result, order, instruments, conditions)),
        rejected=tuple(chain.from_iterable(part.rejected for part in parts)),
        instruments=instruments,
        statements=letterhead.statements,
        authorisation=issue.authorisation,
        evidence=_evidence(source, issue.software),
        appearance=Appearance(
            language=letterhead.language,
            files=dict(letterhead.files),
            layouts=dict(issue.layouts),
        ),
    )


def certifiable(source: Source) -> None:
    """Raise DataError with the reason if a run cannot have a certificate."""
    info = source.stored.info
    for run in _runs(source):
        if run.header.salvaged:
            raise DataError(
                f"{run.header.run_id} was salvaged from a damaged file, and is never certified",
                hint="repeat the run, or certify the run of a sound copy of the file",
            )
        # A run that stopped at a limit can be certified as a fail; a partner run has to be whole.
        is_fail = run is source.stored and run.info.outcome == Outcome.STOPPED_AT_LIMIT
        if run.info.outcome != Outcome.COMPLETED and not is_fail:
            why = f": {run.info.reason}" if run.info.reason else ""
            hint = "only a completed run is a test that a certificate can report"
            if not run.info.sealed:
                hint += f"; 'rigrunner resume {run.header.run_id}' completes it"
            raise DataError(f"{run.header.run_id} ended as '{run.info.outcome}'{why}", hint=hint)
    if not info.sealed:
        raise DataError(
            f"{source.stored.header.run_id} is not sealed: its program was interrupted",
            hint="repeat the run; a certificate needs a run.h5",
        )
    # Called for their errors: results that cannot be stated.
    certified_of(source.result)
    named_of(source.result)


def restrictions_of(source: Source, *, requested: bool) -> Iterator[Restriction]:
    """Yield every reason why a document on this run is 'not for certification'."""
    drafts = [run for run in _runs(source) if _approval(run).state != APPROVED]
    for run in drafts:
        approval, header = _approval(run), run.header
        words = f"{header.procedure_id} revision {header.procedure_revision}"
        yield Restriction(
            code="draft_procedure", detail=f"{words}: {approval.note or approval.state}"
        )
    station, tested = source.stored.header.station_id, source.result.run
    # The kinds of calibration in the registers of all these runs: 'simulated', 'trial', ...
    instruments = instruments_of(tested, *tested.partners.values())
    calibrations = {entry.calibration for entry in instruments}
    simulated, trial = source.simulated or "simulated" in calibrations, "trial" in calibrations
    if simulated:
        yield Restriction(code="simulated", detail=station)
    if trial:
        yield Restriction(code="trial", detail=station)
    tapes = [tape for run in _runs(source) if (tape := run.header.provenance.get(REPLAYED))]
    for tape in tapes:
        yield Restriction(code="replayed", detail=tape)
    inconclusive = [
        check.name
        for check in source.result.every_check
        if check.consequence is Consequence.INCONCLUSIVE
    ]
    if inconclusive:
        yield Restriction(code="inconclusive_check", detail=", ".join(inconclusive))
    if requested and not (drafts or simulated or trial or tapes or inconclusive):
        yield Restriction(code="requested")


def _runs(source: Source) -> tuple[StoredRun, ...]:
    """Return the run and its partner runs."""
    return (source.stored, *source.stored.partners.values())


def _approval(run: StoredRun) -> Approval:
    approval = run.header.approval
    return Approval(
        **{"state": DRAFT, **{name: approval[name] for name in _APPROVAL if name in approval}}
    )


def _method(run: StoredRun, result: Result, parts: Sequence[CertifiedDetails]) -> Method:
    header, part = run.header, next((part for part in parts if part.method), None)
    settings = plain(result.settings)
    assert isinstance(settings, dict)  # noqa: S101  (of a mapping `plain` makes a dict)
    return Method(
        procedure_id=header.procedure_id,
        revision=header.procedure_revision,
        title=header.procedure_title,
        sha256=_sha256(header.procedure_text),
        called={name: _sha256(text) for name, text in header.called_texts.items()},
        approval=_approval(run),
        symbol=result.symbol,
        measurand=result.measurand,
        compensation=part.method if part else "",
        quantity=part.quantity if part else "",
        analysis=settings,
    )


def _evidence(source: Source, software: Mapping[str, str]) -> Evidence:
    run = source.stored
    partners = {name: _run_evidence(partner, "") for name, partner in run.partners.items()}
    return Evidence(
        run=_run_evidence(run, source.file_sha256),
        **{key: partners.pop(name, None) for name, key in KEYS.items()},
        partner_runs=partners,
        station_sha256=_sha256(run.header.station_text),
        software=dict(run.header.provenance),
        issued_with=dict(software),
        revisions={"certificate": REVISION, **source.result.revisions},
    )


def _run_evidence(run: StoredRun, file_sha256: str) -> RunEvidence:
    header = run.header
    return RunEvidence(
        run_id=header.run_id,
        procedure_id=header.procedure_id,
        procedure_revision=header.procedure_revision,
        started_utc=header.started_utc,
        digest_sha256=run.digest,
        manifest_sha256=run.manifest_sha256,
        file_sha256=file_sha256,
    )


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
