"""What the record of the torque gives to certificates and to plugins of 0.1.0."""

from __future__ import annotations

import pytest

from rigrunner.api import AnalysisDetails
from rigrunner.api.results import Result
from rigrunner_bearings.api.torque import TorqueDetails
from unit.analysis.helpers_analysis import analysed, no_load_spec, recording, run_of


def result(*details):
    return Result(run=run_of(), measurand="", symbol="", details=details)


def test_a_certificate_rests_on_the_channels_of_torque_and_load():
    run = run_of(recording([1.0] * 10, load_n=1000.0))
    (torque,) = analysed(run, None, no_load_spec()).details
    assert torque.certified(run).channels == {"tester.torque", "tester.load"}


def test_plugins_made_by_the_first_version_still_find_the_compensations():
    kept = TorqueDetails(compensations={"a": None})
    with pytest.warns(DeprecationWarning, match="import compensations_of from"):
        assert result(AnalysisDetails(), kept).compensations == {"a": None}
    with pytest.warns(DeprecationWarning, match="import compensations_of from"):
        assert result(AnalysisDetails()).compensations == {}
