"""The sections of a report, collected from the modules of views."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.data import Measurement, Recording
from rigrunner.api.limits import ValueLimit
from rigrunner_reports.contents import contents
from rigrunner_reports.page import make_page
from rigrunner_reports.render import html
from unit.rigrunner_reports.helpers_report import loaded_result, no_load_result, report_input


@pytest.mark.parametrize("result", [loaded_result, no_load_result])
def test_contents_list_every_section_in_order(result):
    page = html(report_input(result())).decode("utf-8")
    listed = re.findall(r'<li><a href="#([a-z]+)">', page)
    assert listed == re.findall(r'<section id="([a-z]+)"', page)
    assert len(listed) == len(set(listed)) >= 8


def test_section_declared_by_a_view_is_placed_in_order():
    report = report_input(loaded_result())
    names = [section.name for section, _ in contents(report, make_page(report))]
    assert names[:2] == ["result", "frequency"], "no value has a limit: no such section"
    limited = [section.name for section, _ in contents(*with_limits(report))]
    assert limited[:3] == ["result", "measured", "frequency"]


def with_limits(report):
    """Return a report on measured values with limits, and its page."""
    row = Measurement(
        name="readings",
        utc="2026-03-02T09:15:00Z",
        setpoints={},
        values={"oven.temperature": 300.0},
        units={"oven.temperature": "K"},
        limits=(ValueLimit("oven.temperature", 290.0, 310.0, "K"),),
    )
    run = replace(report.result.run, measurements=(row,))
    limited = replace(report, result=replace(report.result, run=run))
    return limited, make_page(limited)


def test_run_without_an_analysis_shows_recordings_tables_and_events():
    report, _ = with_limits(report_input(loaded_result(), events=EVENTS))
    run = report.result.run
    row = replace(run.measurements[0], name="idle", limits=(), values={"oven.temperature": 301.0})
    recording = Recording(
        "soak", 10.0, "2026-03-02T09:15:00Z", {}, {"oven.temperature": np.arange(30.0)}, row.units
    )
    run = replace(run, measurements=(row, row), recordings=(recording,))
    plain = replace(report.result, run=run, details=(), checks=())
    report = replace(report, result=plain)
    page = html(report).decode("utf-8")
    assert "Recording soak." in page
    assert "oven.temperature: 0 to 29 K" in page
    assert "Table idle, over its rows." in page
    assert "the door was opened" in page


EVENTS = ({"utc": "2026-03-02T09:15:01Z", "kind": "alarm", "text": "the door was opened"},)
