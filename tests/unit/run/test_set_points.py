"""Results in keys of packages, and keys that no installed package reads."""

from __future__ import annotations

import pytest

from rigrunner.api.summaries import SummaryParts
from rigrunner.cli.summary import summary
from rigrunner.run import set_points
from rigrunner.run.set_points import estimates_of_packages, results_in, unread
from rigrunner.tools.comparing.results import result_changes


def document(*values, note=""):
    return {
        "measurand": {"name": "wear"},
        "headline": {"method": None, "compensated": None},
        "decision": None,
        "checks": [],
        "points": [{"at": 5.0, "value": value, "note": note} for value in values],
        "fits": [],
    }


def results(read):
    for point in read["points"]:
        note = {"note": point["note"]} if point["note"] else {}
        estimate = {"value": point["value"], "unit": "V", "expanded_uncertainty_95": 0.1, **note}
        at = {"current": {"value": point["at"], "unit": "A"}}
        yield {"name": "wear", "coordinates": at, "estimate": estimate}


@pytest.fixture
def installed(monkeypatch):
    """Return a function that sets the readers of the installed packages."""

    def only(*readers):
        monkeypatch.setattr(set_points, "_readers", lambda: readers)
        monkeypatch.setattr("rigrunner.cli.summary.package_summaries", lambda: readers)

    return only


@pytest.fixture
def reader():
    return SummaryParts(
        facts=lambda _: (), blocks=lambda _: (), checks=lambda _: (),
        reads=["points"], results=results,
    )  # fmt: skip


def test_package_reads_its_own_keys(installed, reader):
    installed(reader)
    (result,) = results_in(document(1.5))
    assert (result["name"], result["estimate"]["value"]) == ("wear", 1.5)
    assert results_in(document(1.5, note=" from scatter alone")) == []
    places = [name for name, _ in estimates_of_packages(document(1.5, 1.6))]
    assert places == ["at 5 A", "at 5 A (2)"]
    assert unread(document(1.5)) == []
    (change,) = result_changes(document(1.5), document(1.7))
    assert change.text.startswith("at 5 A: 1.50 and 1.70 V: +0.20 V, beyond their combined U")


def test_keys_that_no_installed_package_reads_are_reported(installed):
    installed()
    assert unread(document(1.5)) == ["points"]
    assert unread(document()) == []
    assert results_in(document(1.5)) == []
    (change,) = result_changes(document(1.5), document(1.7))
    assert change.matters
    assert change.text == "points differs, and no installed package reads it"
    assert list(result_changes(document(1.5), document(1.5))) == []
    assert summary(document(1.5)) == "not shown: points, as no installed package reads it"
