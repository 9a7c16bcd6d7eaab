"""The shipped report formats. This module loads neither numpy nor matplotlib nor jinja2."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import (
    CertificateFormatRecord,
    NoSettings,
    ReportFormatRecord,
    StudyFormatRecord,
    hookimpl,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import CertificateInput, ReportInput, StudyInput

api_version = 1


@hookimpl
def rigrunner_report_formats() -> list[ReportFormatRecord]:
    """Return the formats of results."""
    return [
        ReportFormatRecord(
            name="html",
            help="One self-contained page, for the screen and for A4",
            suffix=".html",
            factory=_html,
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
            revision=6,
            factory=_certificate_html,
        ),
        CertificateFormatRecord(
            name="pdf",
            help="Tagged A4 pages with bookmarks and page numbers, for the record",
            suffix=".pdf",
            revision=6,
            factory=_certificate_pdf,
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
            factory=_study_html,
        )
    ]


def _html(settings: NoSettings) -> Callable[[ReportInput], bytes]:  # noqa: ARG001  (nothing to set)
    from rigrunner_reports.render import html  # noqa: PLC0415  (matplotlib takes most of a second)

    return html


def _study_html(settings: NoSettings) -> Callable[[StudyInput], bytes]:  # noqa: ARG001  (nothing to set)
    from rigrunner_reports.studies.render import html  # noqa: PLC0415  (loads matplotlib)

    return html


def _certificate_html(settings: NoSettings) -> Callable[[CertificateInput], bytes]:  # noqa: ARG001  (nothing to set)
    from rigrunner_reports.certificate.render import html  # noqa: PLC0415  (loads matplotlib)

    return html


def _certificate_pdf(settings: NoSettings) -> Callable[[CertificateInput], bytes]:  # noqa: ARG001  (nothing to set)
    from rigrunner_reports.certificate.pdf import pdf_maker  # noqa: PLC0415  (loads matplotlib)

    return pdf_maker()
