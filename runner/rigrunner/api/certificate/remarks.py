"""Opinions, external results, deviations and restrictions of a certificate."""

from __future__ import annotations

from typing import Literal

from rigrunner.api.certificate.part import Part, Text


class Opinion(Part):
    """An opinion or interpretation, marked as such (7.8.7)."""

    text: Text
    by: Text


class ExternalResult(Part):
    """A result that another provider supplied (7.8.2.1 p)."""

    text: Text
    provider: Text


DeviationKind = Literal[
    "intervention",
    "override",
    "alarm",
    "note",
    "failed_step",
    "repeated",
    "failed_check",
    "remark",
    "calibration",
    "range",
    "load",
    "conditions",
    "stated",
]


class Deviation(Part):
    """One addition to, deviation from or exclusion from the method (7.8.2.1 n)."""

    kind: DeviationKind
    run_id: Text
    """The run in which it happened: this one or a partner run."""
    where: str = ""
    """Step, source, check or channel."""
    text: str
    """The recorded text."""
    by: str = ""
    reason: str = ""
    utc: str = ""


class Restriction(Part):
    """Why the document is a specimen and not a certificate."""

    code: Literal[
        "draft_procedure", "simulated", "trial", "replayed", "inconclusive_check", "requested"
    ]
    detail: str = ""
