"""Readings beyond the range of their calibration, if no analysis names instruments."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rigrunner.api.certificate import InstrumentEntry
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


def entry(certificate="C-1", channel="rig.force", **changes):
    texts = ("maker", "type", "serial", "laboratory", "calibrated", "due", "range")
    known = {"channel": channel, "certificate": certificate, "uncertainty": {}}
    return InstrumentEntry.model_validate(dict.fromkeys(texts, "") | known | changes)


@pytest.mark.parametrize(
    ("entries", "certificates"),
    [
        ([entry()], ("C-1",)),
        ([entry(), entry("C-2", channel="rig.gap")], ("C-1", "C-2")),
        ([entry(), entry("", channel="rig.gap")], ()),
        ([entry(overdue=True)], ()),
        ([entry(calibration="trial")], ()),
        ([entry("", calibration="simulated")], ()),
        ([], ()),
    ],
)
def test_result_is_traceable_if_each_channel_has_a_valid_calibration(
    monkeypatch, entries, certificates
):
    """JCGM 200:2012, 2.41: an unbroken chain of calibrations."""
    monkeypatch.setattr(validity, "certified_of", lambda _result: ())
    traceability = validity.traceability_of(SimpleNamespace(), entries)
    assert traceability.certificates == certificates
    assert traceability.claimed is bool(certificates)
