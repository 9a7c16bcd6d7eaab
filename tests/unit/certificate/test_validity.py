"""Which readings lie beyond the range of their calibration, where no analysis names instruments."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rigrunner.certificate import validity

BEYOND = {"rig.force": "-2 to 12 kN"}


@pytest.mark.parametrize(
    ("named", "expected"),
    [((), [("range", "rig.force", "-2 to 12 kN", "R-1")]), (("rig.force",), [])],
)
def test_a_channel_beyond_its_range_counts_where_no_analysis_names_instruments(
    monkeypatch, named, expected
):
    of_analyses = [SimpleNamespace(channels=frozenset(named), deviations=())]
    monkeypatch.setattr(validity, "certified_of", lambda _result: of_analyses)
    result = SimpleNamespace(run=SimpleNamespace(run_id="R-1"), beyond=BEYOND)
    deviations = [(d.kind, d.where, d.text, d.run_id) for d in validity.not_calibrated(result)]
    assert deviations == expected
