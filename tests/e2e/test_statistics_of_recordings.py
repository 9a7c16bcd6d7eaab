"""Repeated recordings: some are kept whole, and the statistics of all are kept."""

from __future__ import annotations

import json
from math import sqrt

import numpy as np
import pytest

from helpers_cli import call
from rigrunner.run.locate import find_station
from rigrunner.runfile import read

STATION = find_station("simulated")
WEAR = """\
rigrunner: procedure/2
id: WEAR
revision: "A"
title: Wear blocks
uses: {tester: swing_tester}
main:
  - set: {tester.load: 1000 N, tester.frequency: 10 Hz}
  - repeat:
      times: 5
      as: block
      label: {phase: wear}
      steps:
        - record:
            channels: [tester.angle, tester.torque, tester.temperature]
            duration: 1 s
            statistics: {tester.torque: [rms, peak_to_peak], tester.temperature: [mean]}
            keep_every: 2
teardown:
  - set: {tester.frequency: 0 Hz, tester.load: 0 N}
analysis:
  - readings: {of: tester.torque.rms, per: block, result: {name: friction, unit: mN·m}}
  - readings: {of: tester.torque.peak_to_peak, per: block, result: {name: span, unit: N·m}}
  - readings: {of: tester.temperature.mean, per: block, result: {name: warmth, unit: °C}}
"""

KEPT = "            statistics: {tester.torque: [rms, peak_to_peak], tester.temperature: [mean]}\n"
SWEPT = """\
        - sweep:
            set: tester.frequency
            over: [5 Hz, 10 Hz]
            steps:
            - record:
"""


def written(folder, *changes):
    text = WEAR
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "wear.yaml").write_text(text, encoding="utf-8")
    return folder / "wear.yaml"


def run(folder, *changes):
    called = call("run", written(folder, *changes), "--station", STATION, "--unattended",
                  "--runs", folder / "runs")  # fmt: skip
    assert called.code == 0, called.err
    (run_folder,) = (folder / "runs").iterdir()
    result = json.loads((run_folder / "result.json").read_text(encoding="utf-8"))
    return run_folder, read(run_folder), result


@pytest.fixture(scope="module")
def thinned(tmp_path_factory):
    return run(tmp_path_factory.mktemp("thinned"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run(tmp_path_factory.mktemp("whole"), ("            keep_every: 2\n", ""))


def test_every_second_recording_is_kept_whole(thinned):
    _, stored, _ = thinned
    assert [recording.coordinates["block"] for recording in stored.recordings] == [1, 3, 5]
    assert {recording.samples for recording in stored.recordings} == {10_000}


def test_statistics_of_all_recordings_match_their_samples(thinned, whole):
    rows, recordings = thinned[1].measurements, whole[1].recordings
    assert [row.coordinates["block"] for row in rows] == [1, 2, 3, 4, 5]
    assert [bool(row.recording) for row in rows] == [True, False, True, False, True]
    for row, recording in zip(rows, recordings, strict=True):
        torque = np.asarray(recording.channels["tester.torque"])
        assert row.values["tester.torque.rms"] == pytest.approx(sqrt(np.mean(torque**2)))
        assert row.values["tester.torque.peak_to_peak"] == np.ptp(torque)
        temperature = np.asarray(recording.channels["tester.temperature"])
        assert row.values["tester.temperature.mean"] == pytest.approx(temperature.mean())
        assert row.units["tester.torque.rms"] == "N·m"
    assert len({row.values["tester.torque.rms"] for row in rows}) == len(rows)


def test_result_of_statistics_has_the_uncertainty_of_the_instrument(thinned):
    results = {(result["name"], result["coordinates"]["block"]["value"]): result
               for result in thinned[2]["results"]}  # fmt: skip
    row = thinned[1].measurements[1]
    friction = results["friction", 2.0]["estimate"]
    rms_nm = row.values["tester.torque.rms"]
    assert friction["value"] == pytest.approx(1e3 * rms_nm)
    limits_nm = (0.003 * rms_nm, 0.02, 0.02, 0.0005 * 10)  # gain, offset, drift, of full scale
    u_nm = sqrt(sum(limit_nm**2 for limit_nm in limits_nm) / 3)
    assert friction["standard_uncertainty"] == pytest.approx(1e3 * u_nm, rel=1e-6)
    span = results["span", 2.0]["estimate"]
    span_nm = row.values["tester.torque.peak_to_peak"]
    parts_nm = (0.003 * span_nm, 2 * 0.02, 2 * 0.0005 * 10)  # the offset cancels
    u_nm = sqrt(sum(part_nm**2 for part_nm in parts_nm) / 3)
    assert span["standard_uncertainty"] == pytest.approx(u_nm, rel=1e-6)
    kelvin = row.values["tester.temperature.mean"]
    assert results["warmth", 2.0]["estimate"]["value"] == pytest.approx(kelvin - 273.15)
    assert any("root mean square of a recording" in note for note in thinned[2]["notes"])


def test_plan_states_the_disk_space(tmp_path):
    plans = [call("plan", written(tmp_path / name, *changes), "--station", STATION).out
            for name, changes in {"thinned": (), "whole": (("            keep_every: 2\n", ""),)
                                  }.items()]  # fmt: skip
    samples = 10_000 * 3 * 8
    assert f"disk      {3 * samples / 1e6:.1f} MB" in plans[0]
    assert f"disk      {5 * samples / 1e6:.1f} MB" in plans[1]
    assert "Keep statistics of angle" in plans[0]
    assert "Keep statistics of angle" not in plans[1]


def test_each_set_point_is_counted_separately(tmp_path):
    sweep = (
        ("        - record:\n", SWEPT),
        ("            channels", "                channels"),
        ("            duration", "                duration"),
        ("            statistics", "                statistics"),
        ("            keep_every: 2", "                keep_every: 3"),
    )  # fmt: skip
    _, stored, _ = run(tmp_path, *sweep, ("per: block", "per: [block, tester.frequency]"))
    kept = [(recording.coordinates["block"], recording.setpoints["tester.frequency"])
            for recording in stored.recordings]  # fmt: skip
    assert kept == [(1, 5.0), (1, 10.0), (4, 5.0), (4, 10.0)]
    assert len(stored.measurements) == 10


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        (
            KEPT,
            "",
            14,
            "the key 'statistics' is missing: without it nothing is kept of the others",
        ),
        ("tester.temperature: [mean]}", "tester.load: [mean]}", 16,
         "tester.load is not recorded by this step"),
        ("of: tester.torque.rms", "of: tester.torque.mean", 21,
         "tester.torque.mean is not measured in any step"),
        ("[rms, peak_to_peak]", "[rms, median]", 16, "median"),
    ],
)  # fmt: skip
def test_impossible_statistics_are_refused_with_their_line(tmp_path, old, new, line, said):
    file = written(tmp_path, (old, new))
    called = call("check", file, "--station", STATION)
    assert called.code == 3
    assert f"wear.yaml:{line}:" in called.err
    assert said in called.err


def test_statistics_are_shown_reported_and_verified(thinned):
    folder, _, _ = thinned
    shown = call("show", folder).out
    assert "tester.torque.rms / N·m" in shown
    assert call("verify", folder).code == 0
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "tester.torque.rms" in page
