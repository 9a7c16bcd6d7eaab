"""Values of `measure` steps: from a procedure to the run file and back."""

from __future__ import annotations

import h5py
import pytest

from helpers_tester import run
from rigrunner.api.events import Outcome
from rigrunner.run.stored import open_run

PROCEDURE = """\
rigrunner: procedure/2
id: TABLE
revision: "A"
title: A table of values
uses: {tester: tester}
main:
  - measure: {channels: [tester.temperature], name: room}
  - sweep:
      set: tester.load
      over: [100 N, 500 N]
      steps:
        - measure: {channels: [tester.load, tester.torque], name: rest, duration: 0.5 s}
teardown:
  - set: {tester.load: 0 N}
"""
pytestmark = pytest.mark.usefixtures("tester")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("table")
    (folder / "p.yaml").write_text(PROCEDURE, encoding="utf-8")
    return run(folder / "p.yaml", folder / "runs")


def test_measured_values_are_read_with_their_setpoints(finished):
    assert finished.outcome is Outcome.COMPLETED, finished.reason
    data = open_run(finished.folder).data

    assert [(row.name, row.setpoints) for row in data.measurements] == [
        ("room", {}),
        ("rest", {"tester.load": 100.0}),
        ("rest", {"tester.load": 500.0}),
    ]
    room, low, high = data.measurements
    assert room.values == {"tester.temperature": pytest.approx(296.65, abs=0.2)}
    assert room.units == {"tester.temperature": "K"}
    assert low.values["tester.load"] == pytest.approx(100, abs=0.1)
    assert high.values["tester.load"] == pytest.approx(500, abs=0.1)
    assert high.units == {"tester.load": "N", "tester.torque": "N·m"}
    assert data.recordings == ()


def test_run_file_has_measured_values_as_tables(finished):
    with h5py.File(finished.folder / "run.h5") as file:
        table = file["entry/measurements/rest"]
        load = table["values/tester_load"]
        assert load.attrs["units"] == "N"
        assert list(table["setpoints/tester_load"][()]) == [100.0, 500.0]
        assert [round(value) for value in load[()]] == [100, 500]
        assert len(table["utc"]) == 2


def test_different_value_changes_digest(finished, tmp_path):
    text = PROCEDURE.replace("500 N", "501 N")
    (tmp_path / "p.yaml").write_text(text, encoding="utf-8")
    second = run(tmp_path / "p.yaml", tmp_path / "runs")

    assert open_run(finished.folder).data.digest != open_run(second.folder).data.digest
