"""Breakaway torque under load after times at rest: the shipped procedure, without Python code."""

from __future__ import annotations

import json
from math import log10

import numpy as np
import pytest

from helpers_cli import call
from rigrunner.api.errors import ExitCode
from rigrunner.runfile import read, read_truth

DWELLS_S = (10.0, 60.0, 600.0)
LOAD_N, ARM_M, FIXTURE_NM = 1000.0, 0.0005, 0.004
KINETIC_NM = 0.22 + ARM_M * LOAD_N
"""The simulated bearing by its settings: 0.22 N·m without load, 0.5 mm more under load."""


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    runs = tmp_path_factory.mktemp("runs")
    called = call(
        "run", "loaded_breakaway", "--station", "simulated_loaded_bench", "--runs", runs,
        "--unattended",
    )  # fmt: skip
    assert called.code == ExitCode.PASS, called.err
    (folder,) = runs.iterdir()
    return folder, json.loads((folder / "result.json").read_text(encoding="utf-8"))


def estimates(document, name):
    results = [result for result in document["results"] if result["name"] == name]
    assert [result["coordinates"]["dwell"]["value"] for result in results] == list(DWELLS_S)
    return [result["estimate"] for result in results]


@pytest.mark.thorough
def test_each_dwell_has_its_own_breakaway_torque(measured):
    """Against the truth of each start; noise raises the largest sample a little."""
    folder, document = measured
    truth = read_truth(folder)
    starts = {
        dwell: [
            truth[recording.name]["breakaway_torque_nm"] + FIXTURE_NM
            for recording in read(folder).recordings
            if recording.coordinates == {"dwell": dwell, "state": "start"}
        ]
        for dwell in DWELLS_S
    }
    for dwell, estimate in zip(DWELLS_S, estimates(document, "static_torque"), strict=True):
        assert len(starts[dwell]) == 5
        assert estimate["value"] == pytest.approx(np.mean(starts[dwell]), abs=0.01)
        scale = KINETIC_NM / 0.22
        expected = scale * (0.30 + 0.015 * log10(dwell)) + FIXTURE_NM
        assert abs(estimate["value"] - expected) < 3 * 0.03 * expected / 5**0.5


@pytest.mark.thorough
def test_static_against_kinetic_torque(measured):
    _, document = measured
    kinetic = estimates(document, "kinetic_torque")
    for estimate in kinetic:
        assert (
            abs(estimate["value"] - KINETIC_NM - FIXTURE_NM) <= estimate["expanded_uncertainty_95"]
        )
    static, ratio = estimates(document, "static_torque"), estimates(document, "static_to_kinetic")
    for below, above, estimate in zip(kinetic, static, ratio, strict=True):
        q = (above["value"] - FIXTURE_NM) / (below["value"] - FIXTURE_NM)
        assert estimate["value"] == pytest.approx(100 * q)
        shares = [part["standard_uncertainty"] / part["value"] for part in (above, below)]
        uncorrelated = estimate["value"] * np.hypot(*shares)
        assert estimate["standard_uncertainty"] < uncorrelated  # the gain of the transducer cancels


@pytest.mark.thorough
def test_verdict_report_and_verify(measured):
    folder, document = measured
    assert document["verdict"]["verdict"] == "pass"
    page = (folder / "report.html").read_text(encoding="utf-8")
    for words in ("static over kinetic torque", "breakaway torque after rest", "600 s"):
        assert words in page
    assert call("verify", folder).code == ExitCode.PASS


def test_bench_without_a_load_is_refused():
    called = call("check", "loaded_breakaway", "--station", "simulated_bench")
    assert called.code == ExitCode.INVALID
    assert "loaded_rotation_tester is needed" in called.err
