"""The details of torque for certificates and for plugins of 0.1.0."""

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
    spec,
    swing_point,
)


def result(*details):
    return Result(run=run_of(), measurand="", symbol="", details=details)


def test_certificate_rests_on_torque_and_load_channels():
    run = run_of(recording([1.0] * 10, load_n=1000.0))
    (torque,) = analysed(run, None, no_load_spec()).details
    assert torque.certified(run).channels == {"tester.torque", "tester.load"}


def test_range_deviation_names_the_run_it_occurred_in():
    narrow = instrument().model_copy(
        update={"range_": CalibratedRange(max=parse_quantity("1.5 N·m"))}
    )
    run, no_load = run_of(run_id="loaded"), run_of(run_id="unloaded")
    no_load = replace(no_load, instruments={"tester.torque": narrow})
    details = TorqueDetails(
        loaded=(swing_point([2.0, 2.0], 10.0),), no_load=(swing_point([2.0, 2.0], 10.0),)
    )
    deviations = certified_torque(details, run, no_load).deviations
    (beyond,) = (deviation for deviation in deviations if deviation.kind == "range")
    assert beyond.run_id == "unloaded"


def test_two_loads_at_one_frequency_are_two_certified_recordings():
    """Two points at the same frequency each have their own recording and load."""
    loaded = [
        recording([peak] * 10, load_n=load_n) for peak, load_n in ((1.0, 500.0), (2.0, 1000.0))
    ]
    run = run_of(*(replace(rec, name=name) for rec, name in zip(loaded, "AB", strict=True)))
    no_load = run_of(recording([0.5] * 10, load_n=0.0))
    method = spec(compensations=["peak_same_frequency"], primary="peak_same_frequency")
    (torque,) = analysed(run, no_load, method).details
    points = torque.certified(run).results.points
    assert [(p.recording, p.load_n, round(p.raw_nm, 2)) for p in points] == [
        ("A", 501.5, 1.0),
        ("B", 1001.5, 2.0),
    ]


def test_compensations_still_work_with_deprecation_warning():
    details = TorqueDetails(compensations={"a": None})
    with pytest.warns(DeprecationWarning, match="import compensations_of from"):
        assert result(AnalysisDetails(), details).compensations == {"a": None}
    with pytest.warns(DeprecationWarning, match="import compensations_of from"):
        assert result(AnalysisDetails()).compensations == {}
