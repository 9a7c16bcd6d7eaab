"""Breakaway torque under load after times at rest: the shipped procedure, no line of Python."""

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
"""The simulated bearing as its settings have it: 0.22 N·m without load, 0.5 mm more under load."""


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


def of(document, name):
    found = [each for each in document["results"] if each["name"] == name]
    assert [each["coordinates"]["dwell"]["value"] for each in found] == list(DWELLS_S)
    return [each["estimate"] for each in found]


def test_each_dwell_has_its_own_breakaway_torque(measured):
    """Against the truth of the starts that were made; noise raises a largest sample a little."""
    folder, document = measured
    truth = read_truth(folder)
    starts = {
        dwell: [
            truth[each.name]["breakaway_torque_nm"] + FIXTURE_NM
            for each in read(folder).recordings
            if each.coordinates == {"dwell": dwell, "state": "start"}
        ]
        for dwell in DWELLS_S
    }
    for dwell, found in zip(DWELLS_S, of(document, "static_torque"), strict=True):
        assert len(starts[dwell]) == 5
        assert found["value"] == pytest.approx(np.mean(starts[dwell]), abs=0.01)
        scale = KINETIC_NM / 0.22
        expected = scale * (0.30 + 0.015 * log10(dwell)) + FIXTURE_NM
        assert abs(found["value"] - expected) < 3 * 0.03 * expected / 5**0.5


def test_static_against_kinetic_torque(measured):
    _, document = measured
    kinetic = of(document, "kinetic_torque")
    for found in kinetic:
        assert abs(found["value"] - KINETIC_NM - FIXTURE_NM) <= found["expanded_uncertainty_95"]
    static, ratio = of(document, "static_torque"), of(document, "static_to_kinetic")
    for below, above, found in zip(kinetic, static, ratio, strict=True):
        q = (above["value"] - FIXTURE_NM) / (below["value"] - FIXTURE_NM)
        assert found["value"] == pytest.approx(100 * q)
        shares = [each["standard_uncertainty"] / each["value"] for each in (above, below)]
        alone = found["value"] * np.hypot(*shares)
        assert found["standard_uncertainty"] < alone  # the gain of the transducer cancels


def test_verdict_report_and_verify(measured):
    folder, document = measured
    assert document["verdict"]["verdict"] == "pass"
    page = (folder / "report.html").read_text(encoding="utf-8")
    for words in ("static over kinetic torque", "breakaway torque after rest", "600 s"):
        assert words in page
    assert call("verify", folder).code == ExitCode.PASS


def test_a_bench_without_a_load_cannot_do_it():
    called = call("check", "loaded_breakaway", "--station", "simulated_bench")
    assert called.code == ExitCode.INVALID
    assert "loaded_rotation_tester is needed" in called.err
