"""The shipped report formats. This module loads neither numpy nor matplotlib nor jinja2."""

from __future__ import annotations

from rigrunner.api import (
    CertificateFormatRecord,
    Imported,
    ReportFormatRecord,
    StudyFormatRecord,
    hookimpl,
)

api_version = 1


@hookimpl
def rigrunner_report_formats() -> list[ReportFormatRecord]:
    """Return the formats of results."""
    return [
        ReportFormatRecord(
            name="html",
            help="One self-contained page, for the screen and for A4",
            suffix=".html",
            factory=Imported("rigrunner_reports.render:html", called=False),
        )
    ]


@hookimpl
def rigrunner_certificate_formats() -> list[CertificateFormatRecord]:
    """Return the printed forms of certificates."""
    return [
        CertificateFormatRecord(
            name="html",
            help="One self-contained page, for the screen and for A4",
            suffix=".html",
            revision=7,
            factory=Imported("rigrunner_reports.certificate.render:html", called=False),
        ),
        CertificateFormatRecord(
            name="pdf",
            help="Tagged A4 pages with bookmarks and page numbers, for the record",
            suffix=".pdf",
            revision=7,
            factory=Imported("rigrunner_reports.certificate.pdf:pdf_maker"),
        ),
    ]


@hookimpl
def rigrunner_study_formats() -> list[StudyFormatRecord]:
    """Return the formats of studies of many runs."""
    return [
        StudyFormatRecord(
            name="html",
            help="One self-contained page, for the screen and for A4",
            suffix=".html",
            factory=Imported("rigrunner_reports.studies.render:html", called=False),
        )
    ]
