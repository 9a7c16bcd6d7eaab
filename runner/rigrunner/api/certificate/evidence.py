"""The evidence of a certificate: runs, software, the replaced document, the printed form."""

from __future__ import annotations

from pydantic import Field

from rigrunner.api.certificate.part import Part, Sha256, Text


class RunEvidence(Part):
    """Identity and digests of a run."""

    run_id: Text
    procedure_id: Text
    procedure_revision: Text
    started_utc: Text
    digest_sha256: Sha256
    """Digest of recordings and measurements."""
    manifest_sha256: Sha256 = ""
    """Digest of the manifest of the run; empty for runs older than manifests."""
    file_sha256: Sha256 = ""
    """Digest of the bytes of `run.h5`; empty for a run embedded in another file."""


class Evidence(Part):
    """The digests that link the results to the recordings."""

    run: RunEvidence
    no_load_run: RunEvidence | None
    no_load_run_after: RunEvidence | None = None
    """The second one, after the run, if there are two: they bracket it."""
    partner_runs: dict[str, RunEvidence] = Field({})
    """The partner runs of any other analysis, by name."""
    station_sha256: Sha256
    """Digest of the station's text in UTF-8."""
    software: dict[str, str]
    """Versions of the software that made the run."""
    issued_with: dict[str, str]
    """Versions of the software that made the certificate."""
    revisions: dict[str, int] = Field({})
    """Revision of each method behind the numbers; 1 for a method that is left out."""


class Change(Part):
    """A field that an amendment changed."""

    field: Text
    """Path of the field: 'customer.name'."""
    before: str
    after: str


class Amendment(Part):
    """The document that this one replaces, and why (7.8.8)."""

    number: Text
    """Number of the replaced document."""
    issued_utc: Text
    sha256: Sha256
    """SHA-256 of the JSON of the replaced document."""
    reason: Text
    by: Text
    changes: tuple[Change, ...] = ()


class FurtherCopy(Part):
    """An earlier specimen on the run, and why there is another one."""

    number: Text
    """Number of the first one in force."""
    reason: Text
    by: Text


class Appearance(Part):
    """What the printed forms depend on in addition to this content."""

    language: Text
    files: dict[str, Sha256] = Field({})
    """Digests of the letterhead's files by name: logo, templates, texts, style."""
    layouts: dict[str, int] = Field({})
    """Revision of the layout of each printed form by name; 1 for a form that is left out."""
