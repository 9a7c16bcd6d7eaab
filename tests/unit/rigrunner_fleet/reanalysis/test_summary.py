"""The summary of a re-analysis as CSV, with formulas escaped for spreadsheets."""

from __future__ import annotations

import csv

import pytest

from rigrunner_fleet.reanalysis.summary import Summary, write_summary
from rigrunner_fleet.reanalysis.task import Row


@pytest.mark.parametrize(("raw", "cell"), [(False, "'=1+1"), (True, "=1+1")])
def test_formula_in_a_specimen_name_is_escaped(raw, cell, tmp_path):
    summary = Summary((Row(run="one", specimen="=1+1", torque_nm=-0.5),), (), 1)
    write_summary(tmp_path, summary, raw=raw)
    with (tmp_path / "summary.csv").open(encoding="utf-8", newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["specimen"], row["torque_nm"]) == (cell, "-0.5")
