"""What the record of the torque gives to certificates and to plugins of 0.1.0."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rigrunner.api import AnalysisDetails, parse_quantity
from rigrunner.api.calibration import CalibratedRange
from rigrunner.api.results import Result
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.torque.certified import certified_torque
from unit.analysis.helpers_analysis import (
    analysed,
    instrument,
    no_load_spec,
    recording,
    run_of,
    swing_point,
)


def result(*details):
    return Result(run=run_of(), measurand="", symbol="", details=details)


def test_a_certificate_rests_on_the_channels_of_torque_and_load():
    run = run_of(recording([1.0] * 10, load_n=1000.0))
    (torque,) = analysed(run, None, no_load_spec()).details
    assert torque.certified(run).channels == {"tester.torque", "tester.load"}


def test_what_is_beyond_a_calibrated_range_is_said_of_the_run_in_which_it_was():
    narrow = instrument().model_copy(
        update={"range_": CalibratedRange(max=parse_quantity("1.5 N·m"))}
    )
    run, no_load = run_of(run_id="loaded"), run_of(run_id="unloaded")
    no_load = replace(no_load, instruments={"tester.torque": narrow})
    found = TorqueDetails(
        loaded=(swing_point([2.0, 2.0], 10.0),), no_load=(swing_point([2.0, 2.0], 10.0),)
    )
    deviations = certified_torque(found, run, no_load).deviations
    (beyond,) = (each for each in deviations if each.kind == "range")
    assert beyond.run_id == "unloaded"


def test_plugins_made_by_the_first_version_still_find_the_compensations():
    kept = TorqueDetails(compensations={"a": None})
    with pytest.warns(DeprecationWarning, match="import compensations_of from"):
        assert result(AnalysisDetails(), kept).compensations == {"a": None}
    with pytest.warns(DeprecationWarning, match="import compensations_of from"):
        assert result(AnalysisDetails()).compensations == {}
