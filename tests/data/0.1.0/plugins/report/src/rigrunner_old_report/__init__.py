"""The report old_report: a table of the compensated torque, as CSV."""

import csv
import io
from collections.abc import Callable

from rigrunner.api.hooks import NoSettings, ReportFormatRecord, hookimpl
from rigrunner.api.results import ReportInput

api_version = 1
HEADER = ("method", "frequency in Hz", "raw in N·m", "torque in N·m", "standard uncertainty in N·m")


def write(report: ReportInput) -> bytes:
    """Return the file; the same input gives the same bytes."""
    text = io.StringIO()
    rows = csv.writer(text)
    rows.writerow(HEADER)
    for method, found in report.result.compensations.items():
        for point in found.points:
            torque = point.torque
            rows.writerow([method, point.frequency_hz, point.raw_nm, torque.value, torque.u])
    return text.getvalue().encode("utf-8")


def _make(_: NoSettings) -> Callable[[ReportInput], bytes]:
    return write


@hookimpl
def rigrunner_report_formats() -> list[ReportFormatRecord]:
    """Tell Rigrunner what is in this file."""
    return [
        ReportFormatRecord(
            name="old_report",
            help="Old report: the compensated torque as CSV",
            suffix=".csv",
            factory=_make,
        )
    ]
