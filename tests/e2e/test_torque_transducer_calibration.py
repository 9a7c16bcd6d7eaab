"""The laboratory's own calibration chain: a calibration, its register entry, and its use."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from helpers_cli import call
from helpers_workflow import quick_procedure
from rigrunner.run.locate import find_procedure
from rigrunner_plugins.loopback.lever import (
    CUBIC,
    GAIN,
    HYSTERESIS_NM,
    POSITION_NM,
    ZERO_NM,
    running_lever,
)

pytestmark = [pytest.mark.in_real_time, pytest.mark.thorough]

PROCEDURE = find_procedure("torque_transducer_calibration")
STATION = Path(__file__).parents[2] / "procedures/stations/simulated.yaml"
STEPS = np.arange(-10.0, 11.0, 2.0)


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibration")
    with running_lever() as bench:
        (folder / "station.yaml").write_text(bench.station(), encoding="utf-8")
        called = call(
            "run", PROCEDURE, "--station", folder / "station.yaml", "--unattended", "--runs",
            folder / "runs",
        )  # fmt: skip
    assert called.code == 0, called.err
    (run_folder,) = (folder / "runs").iterdir()
    return run_folder, json.loads((run_folder / "result.json").read_text(encoding="utf-8"))


def indicated(torque):
    """Return the indication of the transducer for a torque, without its other errors."""
    share = torque / 10
    return GAIN * torque + 10 * CUBIC * (share**3 - share)


def test_results_cover_the_true_errors_of_the_transducer(calibrated):
    results = {each["name"]: each for each in calibrated[1]["results"]}

    def is_true(name, truth):
        estimate = results[name]["estimate"]
        assert abs(estimate["value"] - truth) <= estimate["expanded_uncertainty_95"], name

    is_true("hysteresis", 4 * HYSTERESIS_NM * 0.24)
    # a preload, then four loadings in a position, each of which halves the remaining creep
    is_true("zero_return", ZERO_NM * (1 / 4 + 1 / 8 + 1 / 16 + 1 / 32) / 4)
    y = indicated(STEPS) + 2 * HYSTERESIS_NM * STEPS / 10 * (1 - np.abs(STEPS) / 10)  # of both ways
    weights = np.where(STEPS == 0, 4, 2)
    deviation = y - np.polyval(np.polyfit(STEPS, y, 1, w=np.sqrt(weights)), STEPS)
    is_true("nonlinearity", 100 * np.abs(deviation).max() / np.ptp(y))
    assert results["reproducibility"]["estimate"]["unit"] == "N·m"
    (at_ten,) = [
        each["estimate"]["value"]
        for each in calibrated[1]["results"]
        if each["name"] == "reproducibility" and each["coordinates"]["lever.torque"]["value"] == 10
    ]
    spread = POSITION_NM * 1.5 + ZERO_NM * 3 / 8  # cos 0 less cos 120°, and the creep of two series
    assert at_ten == pytest.approx(spread, abs=1e-3)


def test_calibration_passes_verifies_and_is_reported(calibrated):
    folder, document = calibrated
    assert document["verdict"]["verdict"] == "pass"
    assert "hysteresis" in (folder / "report.html").read_text(encoding="utf-8")
    assert call("verify", folder).code == 0


def entry_of(folder):
    called = call(
        "register", "from", folder, "--channel", "tester.torque", "--due", "2099-01-01",
    )  # fmt: skip
    assert called.code == 0, called.err
    return called.out.rstrip()


def test_register_entry_has_the_table_and_the_errors(calibrated):
    folder, _ = calibrated
    called = call(
        "register", "from", folder, "--channel", "tester.torque", "--due", "2099-01-01", "--json",
    )  # fmt: skip
    entry = json.loads(called.out)
    assert entry["certificate"] == folder.name
    assert entry["calibration"] == "trial"  # its standard was one
    points = [{name: text.split()[0] for name, text in point.items() if name != "k"}
              for point in entry["points"]]  # fmt: skip
    assert [float(point["applied"]) for point in points] == [2, 4, 6, 8, 10, -2, -4, -6, -8, -10]
    for point in points:
        deviation = float(point["indicated"]) - indicated(float(point["applied"]))
        assert abs(deviation) <= float(point["U"])
    half_hysteresis = float(entry["accuracy"]["hysteresis"]["limit"].split()[0])
    assert half_hysteresis == pytest.approx(4 * HYSTERESIS_NM * 0.24 / 2, abs=0.001)


@pytest.mark.thorough
def test_starting_torque_uses_the_register_entry(calibrated, tmp_path):
    """The transducer shows 0.6 % too much at small torques: the result is that much smaller."""
    text = STATION.read_text(encoding="utf-8")
    head, _ = text.split("instruments:\n")
    of_filter = "    low_pass: {type: butterworth, order: 2, corner: 1 kHz}"
    entry = f"{entry_of(calibrated[0])}\n{of_filter}\n"
    (tmp_path / "own.yaml").write_text(f"{head}instruments:\n{entry}", encoding="utf-8")
    torques = {}
    for station in (STATION, tmp_path / "own.yaml"):
        runs = tmp_path / station.stem
        for name in ("no_load_inertia_sweep", "starting_torque_1000n"):
            options = ("--station", station, "--unattended", "--runs", runs)
            called = call("run", quick_procedure(tmp_path, name), *options)
            assert called.code in {0, 10}, called.err
        run = max(runs.glob("*STT*"))
        document = json.loads((run / "result.json").read_text(encoding="utf-8"))
        torques[station.stem] = document["headline"]
    share = torques["own"]["compensated"]["value"] / torques["simulated"]["compensated"]["value"]
    assert share == pytest.approx(1 / 1.006, abs=0.002)
    names = " ".join(component["name"] for component in torques["own"]["budget"])
    assert f"transducer hysteresis ({calibrated[0].name})" in names


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ("run.h5", "does not verify|cannot be read|damaged"),
        pytest.param("result.json", "does not verify", marks=pytest.mark.thorough),
    ],
)
def test_changed_run_gives_no_register_entry(calibrated, tmp_path, changed, words):
    import shutil  # noqa: PLC0415  (here alone)

    copy = tmp_path / calibrated[0].name
    shutil.copytree(calibrated[0], copy)
    path = copy / changed
    content = path.read_bytes()
    if changed == "result.json":
        document = json.loads(content)
        document["results"][0]["estimate"]["value"] += 1.0
        path.write_text(json.dumps(document), encoding="utf-8")
    else:
        path.write_bytes(content[: len(content) // 2])
    called = call("register", "from", copy, "--channel", "a.b", "--due", "2099-01-01")
    assert called.code == 5
    assert re.search(words, called.err)


def test_invalid_channel_is_refused(calibrated):
    folder, _ = calibrated
    called = call("register", "from", folder, "--channel", "tester", "--due", "2099-01-01")
    assert called.code == 5
    assert "channel" in called.err
