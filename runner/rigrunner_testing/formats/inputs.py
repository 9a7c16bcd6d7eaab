"""Inputs of formats: runs of the simulated rigs, with hostile names."""

from __future__ import annotations

import threading
from dataclasses import replace
from datetime import date
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from rigrunner.analysis.analyse import analyse
from rigrunner.analysis.document import document
from rigrunner.api.certificate import Authorisation
from rigrunner.api.letterhead import CertificateInput
from rigrunner.api.results import ReportInput
from rigrunner.certificate.content import Issue, make_certificate, restrictions_of
from rigrunner.certificate.letterhead import read_letterhead
from rigrunner.certificate.order import Order, complete
from rigrunner.clock import SimulatedClock, utc_text
from rigrunner.documents.certifying.certify import read_source
from rigrunner.engine import UnattendedAnswers
from rigrunner.procedure import load_procedure
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute
from rigrunner.tools.labfolder import TEMPLATE

if TYPE_CHECKING:
    from rigrunner.certificate.content import Source

PROCEDURE, STATION = "no_load_breakaway", "simulated_bench"
TAG = "<script>alert(7)</script>"
MISCHIEF = f'{TAG}"><img src=x onerror=alert(7)>\'"&amp; 20 % ünit 轴承'
"""A hostile name of a specimen, of a person, and a title."""


@lru_cache(maxsize=1)
def report_inputs() -> tuple[ReportInput, ...]:
    """Return a run with its verdict, and the same run without limits and verdict."""
    source = _source()
    run = replace(
        source.result.run,
        inputs={"specimen": MISCHIEF, "operator": MISCHIEF},
        procedure_title=MISCHIEF,
        people={"operator": MISCHIEF},
    )
    lookup = load_registry()
    procedure = load_procedure(find_procedure(PROCEDURE)).model
    results = (
        analyse(
            run,
            procedure.analysis,
            acceptance=acceptance,
            measurand=procedure.measurand,
            lookup=lookup,
        )
        for acceptance in (procedure.acceptance, None)
    )
    events = ({"utc": run.started_utc, "kind": "note", "text": MISCHIEF},)
    return tuple(
        ReportInput(result, document(result), {}, {"station": MISCHIEF}, events)
        for result in results
    )


@lru_cache(maxsize=1)
def certificate_inputs() -> tuple[CertificateInput, ...]:
    """Return a specimen certificate for a run of the simulated bench."""
    letterhead = read_letterhead(TEMPLATE / "letterhead")
    order = Order(
        customer=MISCHIEF,
        customer_contact=MISCHIEF,
        item=MISCHIEF,
        item_condition="new",
        received=date(2020, 1, 1),
        deviations=(MISCHIEF,),
    )
    source = _source()
    issue = Issue(
        number="X-0001",
        issued_utc=utc_text(SimulatedClock().utc()),
        authorisation=Authorisation(by=MISCHIEF, role="Head of laboratory"),
        restrictions=tuple(restrictions_of(source, requested=True)),
        software={},
    )
    known_inputs = {**source.stored.header.inputs, **source.result.run.people}
    certificate = make_certificate(source, complete(order, {}, known_inputs), letterhead, issue)
    return (CertificateInput(certificate, letterhead),)


@lru_cache(maxsize=1)
def _source() -> Source:
    """Return a run of the simulated bench, read from its folder."""
    registry, clock = load_registry(), SimulatedClock()
    planned = plan_run(find_procedure(PROCEDURE), find_station(STATION), registry, clock)
    with TemporaryDirectory() as folder:
        finished = execute(
            planned,
            runs=Path(folder),
            inputs={"specimen": MISCHIEF, "operator": MISCHIEF},
            partners={},
            answers=UnattendedAnswers(),
            stop=threading.Event(),
        )
        return read_source(finished.folder, registry)
