"""Torque runs of earlier versions are analysed by the methods of today.

Reading them is tested by tests/unit/runfile/test_old_versions.py; the expected values were read
from the file with h5py alone when it was added.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from helpers_cli import call
from rigrunner.documents.packing.unpack import unpack
from rigrunner.run.set_points import estimates_of_packages, results_in
from rigrunner.runfile import read

OLD = Path(__file__).parents[2] / "data" / "format-1" / "run.h5"
RAW_PEAKS_NM = [2.964894580078125, 7.62080888671875]
ENERGY_NM = [0.6330180981779459, 0.6317704478664123]
"""By the method of that time, which subtracted no growth of the support's friction."""
GROWTH = 0.0125
"""Subtracted today if none was measured, at 1000 N (decision 0035)."""


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "runs" / "20260301T120009Z_SSPB-STT-1000_DEMO-0001"
    folder.mkdir(parents=True)
    shutil.copyfile(OLD, folder / "run.h5")
    return folder


def test_old_run_is_analysed_by_current_methods(run):
    output = call("analyse", run, "--json")
    document = json.loads(output.out)
    peaks = [point["raw_peak"]["mean"]["value"] for point in document["points"]]
    assert peaks == pytest.approx(RAW_PEAKS_NM, rel=1e-12)
    points = document["compensations"]["energy"]["points"]
    torques = [point["torque"]["value"] for point in points]
    unloaded_nm = points[0]["raw"]["value"] - ENERGY_NM[0]  # at the slowest set-point
    loads = [point["load"]["value"] for point in document["points"]]
    growth_nm = GROWTH * sum(loads) / len(loads) / 1000 * unloaded_nm
    assert torques == pytest.approx([torque - growth_nm for torque in ENERGY_NM], rel=2e-5)


def test_old_run_is_verified_and_reported(run, tmp_path):
    verified = call("verify", run)
    assert "sealed without a manifest, by an older version" in verified.out
    assert "recordings: 2 with the digest" in verified.out
    assert call("report", run, "--out", tmp_path / "report.html").code == 0


def test_set_points_are_read_from_result_of_old_run(run):
    estimates = dict(estimates_of_packages(read(run / "run.h5").result_document))
    assert list(estimates) == ["at 15 Hz", "at 35 Hz"]
    assert [estimate["value"] for estimate in estimates.values()] == pytest.approx(
        RAW_PEAKS_NM, rel=1e-12
    )


def test_torques_of_0_1_0_run_are_results(tmp_path):
    unpack(OLD.parents[1] / "0.1.0" / "run.zip", tmp_path)
    (folder,) = tmp_path.iterdir()
    results = results_in(read(folder).result_document)
    places = [result["coordinates"]["frequency"]["value"] for result in results]
    assert places == [8.0, 15.0, 25.0, 35.0]
    mean = sum(result["estimate"]["value"] for result in results) / len(results)
    assert f"{mean:.3f}" == "0.729"  # as the certificate of that time prints it
