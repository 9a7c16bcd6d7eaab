"""The live view of the torque: swings as curves, and the analysis of the latest cycles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.analysis_context import AnalysisContext
from rigrunner.api.data import Block
from rigrunner.registry import load_registry
from rigrunner_bearings.conformance.recordings import run_of_swings
from rigrunner_bearings.torque import live
from unit.analysis.helpers_analysis import recording, run_of

SETTINGS = {
    "no_load": {"from": "latest", "procedure": "SSPB-NLI"},
    "compensations": ["peak_same_frequency", "template_inverse"],
    "primary": "template_inverse",
}


def blocks_of(whole, size, start=0):
    for first in range(start, whole.samples, size):
        channels = {name: each[first : first + size] for name, each in whole.channels.items()}
        yield Block(whole.rate_hz, first, 0.0, channels)


def fold_of(settings=SETTINGS):
    registry = load_registry()
    context = AnalysisContext(plugins=registry, measurand="friction torque", symbol="M")
    return (registry.live("swing_torque", settings, context),
            registry.make("analysis", "swing_torque", settings, context))  # fmt: skip


def begun(fold, whole, run):
    fold.begin(replace(whole, channels=dict.fromkeys(whole.channels, np.empty(0))), run)


def follow(fold, whole, run, size=200):
    """Give a fold a whole recording, as it is read; return the curves."""
    begun(fold, whole, run)
    curves = []
    for block in blocks_of(whole, size):
        channels = {
            name: run.readings(name, np.asarray(values, float), run.zero(whole.name, name))
            for name, values in block.channels.items()
        }
        curves += fold.take(replace(block, channels=channels))
    return curves


@pytest.fixture(scope="module")
def swings():
    return run_of_swings(0)


def test_the_torque_is_that_of_the_stored_analysis_to_the_last_bit(swings):
    fold, analysis = fold_of()
    for whole in swings.recordings:
        follow(fold, whole, replace(swings, recordings=()))
        fold.findings()
    found, stored = fold.findings(), analysis(swings)
    assert len(found.results) == len(swings.recordings) == 5
    for live_one, one in zip(found.results, stored.results, strict=True):
        assert (live_one.place, live_one.readings) == (one.place, one.readings)
        assert live_one.estimate == one.estimate
        assert live_one.uncorrected == one.uncorrected
    (figure,) = found.figures
    compensated, measured = figure.series
    assert [each.y for each in compensated.points] == [e.estimate.value for e in stored.results]
    assert [each.y for each in measured.points] == pytest.approx(
        [e.uncorrected.value for e in stored.results]
    )


def test_without_the_partner_run_there_are_the_measured_peaks_alone(swings):
    fold, _ = fold_of()
    follow(fold, swings.recordings[1], replace(swings, recordings=(), partners={}))
    found = fold.findings()
    assert found.results == ()
    ((series,),) = ([each.name for each in figure.series] for figure in found.figures)
    assert series == "measured"


def test_the_swings_are_drawn_and_corrected_once_the_correction_is_known(swings):
    fold, _ = fold_of()
    (whole,) = swings.recordings[2:3]
    run = replace(swings, recordings=())
    begun(fold, whole, run)
    first, *rest = blocks_of(whole, whole.samples // 2)
    before = fold.take(first)
    fold.findings()
    after = [curve for block in rest for curve in fold.take(block)]
    assert {tuple(each.series) for each in before} == {("measured",)}
    assert {tuple(each.series) for each in after} == {("measured", "compensated")}
    assert len(before) + len(after) == 12
    compensated = np.mean([each.series["compensated"] for each in after], axis=0)
    assert np.ptp(compensated) < np.ptp(after[0].series["measured"]) / 2


def test_no_more_is_kept_than_the_latest_samples(monkeypatch):
    monkeypatch.setattr(live, "KEPT_SAMPLES", 2000)
    whole = recording(np.tile(2 + 0.01 * np.arange(60), 5), 10.0)
    fold, _ = fold_of()
    follow(fold, whole, run_of(whole))
    fold.findings()
    wanted = max(2000, live.KEPT_CYCLES * whole.rate_hz / 10.0)
    assert wanted <= fold._current.window().samples <= wanted + 200
    latest = whole.channels["tester.torque"][-fold._current.window().samples :]
    assert np.array_equal(fold._current.window().channels["tester.torque"], latest)


def test_after_a_gap_it_begins_anew(swings):
    fold, _ = fold_of()
    whole = swings.recordings[2]
    run = replace(swings, recordings=())
    begun(fold, whole, run)
    blocks = list(blocks_of(whole, 200))
    for block in (*blocks[:20], *blocks[30:]):
        fold.take(block)
    assert fold._current.window().samples == whole.samples - 30 * 200


@pytest.mark.parametrize("frequency_hz", [0.0, None])
def test_what_does_not_swing_is_left_out(frequency_hz):
    whole = recording(2 + 0.01 * np.arange(60), 10.0)
    setpoints = {} if frequency_hz is None else {"tester.frequency": frequency_hz}
    fold, _ = fold_of()
    assert follow(fold, replace(whole, setpoints=setpoints), run_of(whole)) == []
    assert fold.findings().results == ()


def test_what_is_not_kept_is_drawn_and_enters_no_result(swings):
    fold, _ = fold_of()
    whole = replace(swings.recordings[2], name="")
    assert follow(fold, whole, replace(swings, recordings=()))
    assert (fold.findings().results, fold.findings().figures) == ((), ())
