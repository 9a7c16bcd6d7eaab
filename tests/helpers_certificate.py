"""Issues certificates on a stored run, under the letterhead that a lab folder begins with."""

from __future__ import annotations

import shutil
from datetime import UTC, datetime

from rigrunner.api.certificate import Authorisation
from rigrunner.api.progress import unseen
from rigrunner.certificate.letterhead import read_letterhead
from rigrunner.certificate.numbers import SPECIMEN, Numbers
from rigrunner.certificate.order import Order
from rigrunner.documents.certifying.certify import Request, certify
from rigrunner.registry import Registry, load_registry
from rigrunner.tools.labfolder import TEMPLATE

NOW = datetime(2026, 11, 22, 9, 30, tzinfo=UTC)
ORDER = Order(
    customer="Muster & Söhne <Ltd>",
    customer_contact="7 Customer Road, 11111 Elsewhere",
    customer_reference="PO-4711",
    item="Spherical plain bearing MS14101-9",
    item_condition="new, liner without visible damage",
    received="2025-11-03",
    conditions="Room not air-conditioned.",
    deviations=["Outer ring clamped with two screws in place of four."],
    opinions=[{"text": "The bearing runs in slowly.", "by": "O. Pinion"}],
    external=[{"text": "Hardness 60 HRC", "provider": "Other Laboratory"}],
)


def make_letterhead(folder):
    """Copy the letterhead of a lab folder, without its README."""
    shutil.copytree(TEMPLATE / "letterhead", folder)
    (folder / "README.md").unlink()
    return folder


def without_pdf() -> Registry:
    """Return a registry whose certificates are JSON and HTML alone: the PDF takes seconds."""
    return Registry([plugin for plugin in load_registry().plugins if plugin.record.name != "pdf"])


def request(letterhead, **changes):
    return Request(
        **{
            "letterhead": letterhead,
            "order": ORDER,
            "authorisation": Authorisation(by="A. Nother", role="Head of laboratory"),
            "not_for_certification": True,
            **changes,
        }
    )


def issue(run, letterhead, out, *, now=NOW, registry=None, progress=unseen, **changes):
    """Issue a specimen on a run, a further one where there is one; return what was issued."""
    numbers = Numbers(letterhead, f"{SPECIMEN}-{read_letterhead(letterhead, '').prefix}")
    if numbers.in_force_for(run.name):
        changes.setdefault("further_copy", "for a test")
    certificate_request = request(letterhead, out=out, **changes)
    registry = registry or load_registry()
    return certify(run, certificate_request, registry, now, progress=progress)
