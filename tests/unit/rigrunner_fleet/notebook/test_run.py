"""Runs for notebooks: `rigrunner_fleet.open_run` and `rigrunner_fleet.analyse`."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

import rigrunner_fleet
from rigrunner.api.errors import DataError, UsageError
from rigrunner.runfile import seal
from unit.runfile.helpers_runfile import TWO, write_run

pytestmark = pytest.mark.figures


@pytest.fixture
def small(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    write_run(folder, TWO)
    seal(folder)
    return folder


def test_samples_convert_to_a_data_frame_over_time(small):
    frame = rigrunner_fleet.open_run(small).to_pandas("001_10Hz")
    assert list(frame.columns) == ["tester.angle", "tester.torque"]
    assert frame.index.name == "time_s"
    assert frame.index[1] == 1e-4
    assert frame.attrs["units"] == {"tester.angle": "rad", "tester.torque": "N·m"}
    np.testing.assert_array_equal(frame["tester.torque"], TWO[0].channels["tester.torque"])


def test_samples_convert_to_a_dataset_with_units(small):
    dataset = rigrunner_fleet.open_run(small / "run.h5").to_xarray("002_20Hz")
    assert dict(dataset.sizes) == {"time_s": 40_001}
    assert dataset["tester.torque"].attrs["units"] == "N·m"
    assert dataset.attrs["tester.frequency"] == 10.0
    assert dataset.attrs["tester.temperature"] == 295.25


def test_unknown_names_are_refused_with_the_known_ones(small):
    run = rigrunner_fleet.open_run(small)
    with pytest.raises(UsageError, match="no recording '1'") as caught:
        run.recording("1")
    assert "001_10Hz" in caught.value.hint
    with pytest.raises(UsageError, match="nothing was measured as 'temperature'"):
        run.measurements("temperature")


def test_run_without_a_result_has_samples(small):
    run = rigrunner_fleet.open_run(small)
    assert run.result is None
    assert len(run.points) == 0
    assert len(run.plot("001_10Hz").figure.axes) == 2


def test_points_of_a_run_equal_its_result(quick):
    run = rigrunner_fleet.open_run(quick.loaded)
    document = json.loads((quick.loaded / "result.json").read_text())
    points = document["compensations"]["template_inverse"]["points"]
    assert run.points.column("torque_nm") == [point["torque"]["value"] for point in points]
    inertia = document["compensations"]["template_inverse"]["parameters"]["inertia"]["value"]
    assert inertia in run.figures.column("value")
    (legend,) = run.plot().figure.legends
    assert "limit" in [text.get_text() for text in legend.get_texts()]
    (figure,) = run.plot().picture.panels
    raw = next(series for series in figure.series if series.name == "raw peak")
    assert [point.y for point in raw.points] == run.points.column("raw_peak_nm")


@pytest.mark.thorough
def test_analysing_again_gives_the_same_numbers(quick):
    again = rigrunner_fleet.analyse(quick.loaded)
    assert again.document["headline"] == rigrunner_fleet.open_run(quick.loaded).result["headline"]
    assert again.points == rigrunner_fleet.open_run(quick.loaded).points
    with_partner = rigrunner_fleet.analyse(quick.loaded, {"no_load": quick.no_load})
    assert with_partner.points == again.points
    assert with_partner.plot().figure.axes


def test_missing_run_is_refused(tmp_path):
    with pytest.raises(DataError, match="there is no run"):
        rigrunner_fleet.open_run(tmp_path / "nowhere")


def test_package_imports_lazily():
    script = (
        "import rigrunner_fleet, sys\n"
        "heavy = {'numpy', 'h5py', 'sqlalchemy', 'matplotlib', 'pandas'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
        "assert {'open_run', 'analyse', 'archive'} <= set(dir(rigrunner_fleet))\n"
        "assert not hasattr(rigrunner_fleet, 'nothing')\n"
        "rigrunner_fleet.archive.query\n"
        "assert not {'scipy', 'matplotlib', 'pandas'} & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
