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


def blocks_of(full_recording, size, start=0):
    for first in range(start, full_recording.samples, size):
        channels = {
            name: values[first : first + size] for name, values in full_recording.channels.items()
        }
        yield Block(full_recording.rate_hz, first, 0.0, channels)


def fold_of(settings=SETTINGS):
    registry = load_registry()
    context = AnalysisContext(plugins=registry, measurand="friction torque", symbol="M")
    return (registry.live("swing_torque", settings, context),
            registry.make("analysis", "swing_torque", settings, context))  # fmt: skip


def begin(fold, full_recording, run):
    fold.begin(
        replace(full_recording, channels=dict.fromkeys(full_recording.channels, np.empty(0))), run
    )


def follow(fold, full_recording, run, size=200):
    """Feed a recording to a fold block by block; return the curves."""
    begin(fold, full_recording, run)
    curves = []
    for block in blocks_of(full_recording, size):
        channels = {
            name: run.readings(name, np.asarray(values, float), run.zero(full_recording.name, name))
            for name, values in block.channels.items()
        }
        curves += fold.take(replace(block, channels=channels))
    return curves


@pytest.fixture(scope="module")
def swings():
    return run_of_swings(0)


def test_live_torque_equals_stored_analysis_bit_for_bit(swings):
    fold, analysis = fold_of()
    for full_recording in swings.recordings:
        follow(fold, full_recording, replace(swings, recordings=()))
        fold.findings()
    findings, stored = fold.findings(), analysis(swings)
    assert len(findings.results) == len(swings.recordings) == 5
    for live_result, result in zip(findings.results, stored.results, strict=True):
        assert (live_result.place, live_result.readings) == (result.place, result.readings)
        assert live_result.estimate == result.estimate
        assert live_result.uncorrected == result.uncorrected
    (figure,) = findings.figures
    compensated, measured = figure.series
    assert [point.y for point in compensated.points] == [e.estimate.value for e in stored.results]
    assert [point.y for point in measured.points] == pytest.approx(
        [e.uncorrected.value for e in stored.results]
    )


def test_without_partner_run_only_measured_peaks_are_shown(swings):
    fold, _ = fold_of()
    follow(fold, swings.recordings[1], replace(swings, recordings=(), partners={}))
    findings = fold.findings()
    assert findings.results == ()
    ((series,),) = ([series.name for series in figure.series] for figure in findings.figures)
    assert series == "measured"


def test_swings_are_compensated_once_correction_is_known(swings):
    fold, _ = fold_of()
    (full_recording,) = swings.recordings[2:3]
    run = replace(swings, recordings=())
    begin(fold, full_recording, run)
    first, *others = blocks_of(full_recording, full_recording.samples // 2)
    before = fold.take(first)
    fold.findings()
    after = [curve for block in others for curve in fold.take(block)]
    assert {tuple(curve.series) for curve in before} == {("measured",)}
    assert {tuple(curve.series) for curve in after} == {("measured", "compensated")}
    assert len(before) + len(after) == 12
    compensated = np.mean([curve.series["compensated"] for curve in after], axis=0)
    assert np.ptp(compensated) < np.ptp(after[0].series["measured"]) / 2


def test_only_latest_samples_are_kept(monkeypatch):
    monkeypatch.setattr(live, "KEPT_SAMPLES", 2000)
    full_recording = recording(np.tile(2 + 0.01 * np.arange(60), 5), 10.0)
    fold, _ = fold_of()
    follow(fold, full_recording, run_of(full_recording))
    fold.findings()
    minimum = max(2000, live.KEPT_CYCLES * full_recording.rate_hz / 10.0)
    assert minimum <= fold._current.window().samples <= minimum + 200
    latest = full_recording.channels["tester.torque"][-fold._current.window().samples :]
    assert np.array_equal(fold._current.window().channels["tester.torque"], latest)


def test_fold_restarts_after_a_gap(swings):
    fold, _ = fold_of()
    full_recording = swings.recordings[2]
    run = replace(swings, recordings=())
    begin(fold, full_recording, run)
    blocks = list(blocks_of(full_recording, 200))
    for block in (*blocks[:20], *blocks[30:]):
        fold.take(block)
    assert fold._current.window().samples == full_recording.samples - 30 * 200


@pytest.mark.parametrize("frequency_hz", [0.0, None])
def test_recording_without_frequency_is_ignored(frequency_hz):
    full_recording = recording(2 + 0.01 * np.arange(60), 10.0)
    setpoints = {} if frequency_hz is None else {"tester.frequency": frequency_hz}
    fold, _ = fold_of()
    assert follow(fold, replace(full_recording, setpoints=setpoints), run_of(full_recording)) == []
    assert fold.findings().results == ()


def test_unnamed_recording_is_drawn_but_gives_no_result(swings):
    fold, _ = fold_of()
    full_recording = replace(swings.recordings[2], name="")
    assert follow(fold, full_recording, replace(swings, recordings=()))
    assert (fold.findings().results, fold.findings().figures) == ((), ())
