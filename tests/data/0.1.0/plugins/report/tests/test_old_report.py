"""What must hold of the report old_report."""

from collections.abc import Callable

import pytest

import rigrunner_old_report as plugin


@pytest.mark.conformance("report_format", "old_report")
def test_it_keeps_to_what_every_report_keeps_to(conformance: Callable[[], None]) -> None:
    """One test for each check of the conformance kit; what does not apply is skipped."""
    conformance()


def test_it_is_a_csv_file() -> None:
    """Every column has its unit."""
    (record,) = plugin.rigrunner_report_formats()
    assert record.suffix == ".csv"
    assert all(" in " in column for column in plugin.HEADER[1:])
