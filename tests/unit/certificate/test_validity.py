"""Readings beyond the range of their calibration, if no analysis names instruments."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rigrunner.certificate import validity

BEYOND = {"rig.force": "-2 to 12 kN"}


@pytest.mark.parametrize(
    ("named", "expected"),
    [((), [("range", "rig.force", "-2 to 12 kN", "R-1")]), (("rig.force",), [])],
)
def test_channel_beyond_its_range_counts_if_no_analysis_names_instruments(
    monkeypatch, named, expected
):
    analyses = [SimpleNamespace(channels=frozenset(named), deviations=())]
    monkeypatch.setattr(validity, "certified_of", lambda _result: analyses)
    result = SimpleNamespace(run=SimpleNamespace(run_id="R-1"), beyond=BEYOND)
    deviations = [(d.kind, d.where, d.text, d.run_id) for d in validity.not_calibrated(result)]
    assert deviations == expected
