"""A report of your own: the compensated torque as CSV, for a spreadsheet.

The station names the folder of this file. `rigrunner check-plugin torque_table --drop-in plugins`
checks it, and `rigrunner new report NAME --drop-in` makes another one.
"""

import csv
import io
from collections.abc import Callable

from rigrunner.api import NoSettings, ReportFormatRecord, ReportInput, hookimpl
from rigrunner_bearings.api.torque import TorqueDetails

api_version = 1
HEADER = ("method", "frequency in Hz", "raw in N·m", "torque in N·m", "standard uncertainty in N·m")


def write(report: ReportInput) -> bytes:
    """Return the file; the same input gives the same bytes."""
    text = io.StringIO()
    rows = csv.writer(text)
    rows.writerow(HEADER)
    for method, compensation in TorqueDetails.of(report.result).compensations.items():
        for point in compensation.points:
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
            name="torque_table",
            help="the compensated torque as CSV",
            suffix=".csv",
            factory=_make,
        )
    ]
