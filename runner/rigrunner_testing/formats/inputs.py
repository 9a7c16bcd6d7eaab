"""What formats are given to write: runs of the simulated rigs, with names that mean mischief."""

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
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute
from rigrunner.study.tools import PROCEDURE, tools
from rigrunner.tools.labfolder import TEMPLATE
from rigrunner_testing.compensation.recordings import CLOSED_FORM, swings

if TYPE_CHECKING:
    from rigrunner.api.data import RunData

TAG = "<script>alert(7)</script>"
MISCHIEF = f'{TAG}"><img src=x onerror=alert(7)>\'"&amp; 20 % ünit 轴承'
"""As the name of a specimen, of a person, and as a title."""


@lru_cache(maxsize=1)
def report_inputs() -> tuple[ReportInput, ...]:
    """Return a loaded run with its verdict, and the no-load run alone, which has none."""
    runs = swings(CLOSED_FORM, 0)
    procedure = load_procedure(find_procedure(PROCEDURE)).model
    loaded, no_load = _named(runs.loaded), _named(runs.no_load or runs.loaded)
    asked = procedure.torque_analysis
    alone = asked.model_copy(update={"no_load": None, "compensations": (), "primary_": ""})
    decided = analyse(
        loaded,
        no_load,
        asked,
        acceptance=procedure.acceptance,
        measurand=procedure.measurand,
        lookup=tools().registry,
    )
    undecided = analyse(
        no_load,
        None,
        alone,
        acceptance=None,
        measurand=procedure.measurand,
        lookup=tools().registry,
    )
    events = ({"utc": runs.loaded.started_utc, "kind": "note", "text": MISCHIEF},)
    return tuple(
        ReportInput(found, document(found), {}, {"station": MISCHIEF}, events)
        for found in (decided, undecided)
    )


def _named(run: RunData) -> RunData:
    return replace(
        run,
        inputs={"specimen": MISCHIEF, "operator": MISCHIEF},
        procedure_title=MISCHIEF,
        people={"operator": MISCHIEF},
    )


@lru_cache(maxsize=1)
def certificate_inputs() -> tuple[CertificateInput, ...]:
    """Return a specimen of a certificate on a run of the simulated bench."""
    letterhead = read_letterhead(TEMPLATE / "letterhead")
    order = Order(
        customer=MISCHIEF,
        customer_contact=MISCHIEF,
        item=MISCHIEF,
        item_condition="new",
        received=date(2020, 1, 1),
        deviations=(MISCHIEF,),
    )
    registry, clock, answers = tools().registry, SimulatedClock(), UnattendedAnswers()
    planned = plan_run(
        find_procedure("no_load_breakaway"), find_station("simulated_bench"), registry, clock
    )
    with TemporaryDirectory() as folder:
        finished = execute(
            planned,
            runs=Path(folder),
            inputs={"specimen": MISCHIEF, "operator": MISCHIEF},
            no_load=None,
            answers=answers,
            stop=threading.Event(),
        )
        source = read_source(finished.folder, registry)
    issue = Issue(
        number="X-0001",
        issued_utc=utc_text(clock.utc()),
        authorisation=Authorisation(by=MISCHIEF, role="Head of laboratory"),
        restrictions=tuple(restrictions_of(source, requested=True)),
        software={},
    )
    known = {**source.stored.header.inputs, **source.result.run.people}
    certificate = make_certificate(source, complete(order, {}, known), letterhead, issue)
    return (CertificateInput(certificate, letterhead),)
