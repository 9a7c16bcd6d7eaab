"""By what the document can be proved: runs, software, what it replaces, how it was printed."""

from __future__ import annotations

from pydantic import Field

from rigrunner.api.certificate.part import Part, Sha256, Text


class RunEvidence(Part):
    """The identity of a run's recordings."""

    run_id: Text
    procedure_id: Text
    procedure_revision: Text
    started_utc: Text
    digest_sha256: Sha256
    """Over recordings and measurements."""
    manifest_sha256: Sha256 = ""
    """Over the manifest of everything in the run; empty in runs older than manifests."""
    file_sha256: Sha256 = ""
    """Of the bytes of `run.h5`; empty for a run that is embedded in another's file."""


class Evidence(Part):
    """The digests that link the results to the recordings."""

    run: RunEvidence
    no_load_run: RunEvidence | None
    no_load_run_after: RunEvidence | None = None
    """The second one, after the run, where there are two: they bracket it."""
    partner_runs: dict[str, RunEvidence] = Field({})
    """The partner runs of any other analysis, by name."""
    station_sha256: Sha256
    """Of the station's text in UTF-8."""
    software: dict[str, str]
    """With what the run was made."""
    issued_with: dict[str, str]
    """With what the certificate was made."""
    revisions: dict[str, int] = Field({})
    """By which revision of each method its numbers were computed; of one without it, the first."""


class Change(Part):
    """One field that an amendment changed."""

    field: Text
    """The way to it: 'customer.name'."""
    before: str
    after: str


class Amendment(Part):
    """What this document replaces, and why (7.8.8)."""

    number: Text
    """Of the document that it replaces."""
    issued_utc: Text
    sha256: Sha256
    """Of that document's JSON."""
    reason: Text
    by: Text
    changes: tuple[Change, ...] = ()


class FurtherCopy(Part):
    """That a specimen on the run was issued before, and why there is another one."""

    number: Text
    """Of the first one in force."""
    reason: Text
    by: Text


class Appearance(Part):
    """What the printed forms depend on besides this content."""

    language: Text
    files: dict[str, Sha256] = Field({})
    """The letterhead's files by name: logo, templates, texts, style."""
    layouts: dict[str, int] = Field({})
    """The revision of the layout of each printed form, by its name; without it, the first."""
