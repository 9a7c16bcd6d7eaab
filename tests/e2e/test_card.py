"""The two procedures on the card of the project: run file, raw and compensated torque."""

from __future__ import annotations

import json
import re

import h5py
import numpy as np
import pytest

from helpers_cli import call

NAMES = ("no_load_inertia_sweep", "starting_torque_1000n")
TRUTH_NM = 0.7262
"""The load-induced starting torque of the simulated bearing (Wang et al. 2025)."""


@pytest.fixture(scope="module")
def runs(demo):
    """Return the runs of both shipped procedures."""
    return dict(zip(NAMES, (demo.no_load, demo.loaded), strict=True))


@pytest.mark.parametrize("name", NAMES)
def test_run_file_has_raw_torque_and_angle_of_each_frequency(runs, name):
    with h5py.File(runs[name] / "run.h5") as file:
        recordings = file["entry/recordings"]
        assert len(recordings) == 12
        for group in recordings.values():
            channels = {column.attrs.get("name") for column in group.values()}
            assert {"tester.torque", "tester.angle"} <= channels
            assert group["time"].shape == (group.attrs["samples"],)
        (slow,) = (
            recording for recording in recordings.values() if recording.attrs["name"] == "001_1Hz"
        )
        (torque,) = (
            column for column in slow.values() if column.attrs.get("name") == "tester.torque"
        )
        assert 0.5 < np.abs(torque[()]).max() < 8
        assert torque.attrs["units"] == "N·m"


def test_report_compares_raw_and_compensated_torque(runs):
    document = json.loads((runs[NAMES[1]] / "result.json").read_text(encoding="utf-8"))
    points = document["points"]
    raw = [point["raw_peak"]["mean"]["value"] for point in points]
    assert raw[-1] > 2 * raw[0]  # inertia grows with the square of the frequency
    compensated = document["decision"]["result"]
    assert compensated["value"] == pytest.approx(
        TRUTH_NM, abs=compensated["expanded_uncertainty_95"]
    )
    page = (runs[NAMES[1]] / "report.html").read_text(encoding="utf-8")
    assert "mean raw peak of a swing, and what is left of it" in page  # the figure's caption
    text = re.sub(r"<[^>]+>", " ", page)
    for peak in (raw[0], raw[-1]):
        assert f"{peak:.3f}" in text
    assert f"{compensated['value']:.3f}" in text


@pytest.mark.thorough
@pytest.mark.parametrize("name", NAMES)
def test_run_verifies(runs, name):
    assert call("verify", runs[name]).code == 0
