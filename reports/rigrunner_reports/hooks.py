"""The reports that ship with Rigrunner; nothing here loads numpy, matplotlib or jinja2."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import NoSettings, ReportFormatRecord, hookimpl

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api.results import ReportInput


@hookimpl
def rigrunner_report_formats() -> list[ReportFormatRecord]:
    """Return the formats that a result can be written in."""
    return [
        ReportFormatRecord(
            name="html",
            help="One self-contained page, for the screen and for A4",
            suffix=".html",
            factory=_html,
        )
    ]


def _html(settings: NoSettings) -> Callable[[ReportInput], bytes]:  # noqa: ARG001  (nothing to set)
    from rigrunner_reports.render import html  # noqa: PLC0415  (matplotlib takes most of a second)

    return html
