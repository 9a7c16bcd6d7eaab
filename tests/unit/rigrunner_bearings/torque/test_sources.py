from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.analysis.document import document
from rigrunner.api.data import Measurement
from rigrunner.api.errors import DataError
from rigrunner_bearings.api.points import MotionSource
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.signal.peaks import mean_peak, peak_points
from rigrunner_bearings.torque.settings import SwingTorque
from rigrunner_bearings.torque.sources import of_this_run, sources
from unit.analysis.helpers_analysis import LOADED_SPEC, analysed, recording, run_of

HERTZ = (1.0, 10.0, 20.0, 35.0)
THIS_RUN = SwingTorque.model_validate(
    LOADED_SPEC
    | {
        "no_load": {"from": "this run"},
        "compensations": ["peak_same_frequency", "energy"],
        "primary": "peak_same_frequency",
    }
)


def measured(hertz, load_n, torque_nm, name="table"):
    setpoints = {"tester.load": load_n} | ({} if hertz is None else {"tester.frequency": hertz})
    units = {"tester.frequency": "Hz", "tester.load": "N", "tester.torque": "N·m"}
    return Measurement(
        name, "2026-01-01T12:00:00+00:00", setpoints, {"tester.torque": torque_nm}, units
    )


def no_load_nm(hertz):
    return 0.9 + 0.004 * hertz**2


def tables(**changes):
    """Return a run of single values: without load, and 0.7 N·m more under 1000 N."""
    rows = [measured(hertz, 0.0, no_load_nm(hertz)) for hertz in HERTZ]
    rows += [measured(hertz, 1000.0, no_load_nm(hertz) + 0.7) for hertz in HERTZ]
    return replace(run_of(), measurements=tuple(rows), **changes)


def test_recordings_are_preferred_to_single_values():
    run = replace(tables(), recordings=(recording(np.ones(6)),))
    assert sources(run) == run.recordings


def test_measurements_without_moving_torque_are_ignored():
    room = Measurement("room", "2026-01-01T12:00:00+00:00", {}, {"t.room": 293.0}, {"t.room": "K"})
    at_rest, still = measured(None, 0.0, 0.01), measured(0.0, 0.0, 0.01)
    point = measured(5.0, 0.0, 1.0)
    run = replace(run_of(), measurements=(room, at_rest, still, point))
    assert [source.name for source in sources(run)] == ["table 4"]


def test_run_is_divided_by_set_load():
    run = tables()
    assert [source.setpoints["tester.load"] for source in of_this_run(run, loaded=False)] == [
        0.0
    ] * 4
    assert [source.setpoints["tester.load"] for source in of_this_run(run, loaded=True)] == [
        1000.0
    ] * 4


def test_recordings_are_divided_by_load():
    peaks = np.linspace(1.9, 2.1, 8)
    loaded, bare = recording(peaks + 0.7, 10.0), recording(peaks, 10.0, load_n=0.0)
    result = analysed(run_of(bare, loaded), analysis_spec=THIS_RUN)
    assert [len(TorqueDetails.of(result).loaded), len(TorqueDetails.of(result).no_load)] == [1, 1]
    assert result.headline.value == pytest.approx(0.7, rel=1e-3)


def test_single_value_is_point_without_scatter():
    result = analysed(tables(zeros={"tester.torque": 0.1}), analysis_spec=THIS_RUN)
    point = TorqueDetails.of(result).loaded[1]
    assert point.recording == "table 6"
    assert (point.cycles, point.motion) == (1, MotionSource.ENTERED)
    assert point.peak_nm == pytest.approx([no_load_nm(10.0) + 0.7 - 0.1])
    assert np.isnan(mean_peak(point).u)
    assert np.isnan(result.headline.u)
    assert peak_points(TorqueDetails.of(result).loaded).u_y is None


def test_difference_of_tables():
    result = analysed(tables(), analysis_spec=THIS_RUN)
    compensation = TorqueDetails.of(result).compensations["peak_same_frequency"]
    assert [point.torque.value for point in compensation.points] == pytest.approx([0.7] * 4)
    assert any("scatter is not known" in note for note in compensation.notes)
    assert "angle channel" in TorqueDetails.of(result).compensations["energy"].not_applicable
    assert all(check.ok for check in result.checks)
    (note,) = [check.text for check in result.checks if check.consequence]
    assert "no angle channel: single values at entered frequencies" in note
    assert "only peak methods apply" in note


def test_document_has_single_values():
    content = document(analysed(tables(), analysis_spec=THIS_RUN))
    point = content["points"][0]
    assert (point["cycles"], point["motion"], point["waveform"]) == (1, "entered", None)
    assert point["raw_peak"]["standard_deviation"] == {"value": None, "unit": "N·m"}
    assert "angle channel" in content["compensations"]["energy"]["not_applicable"]


def test_run_without_motion_is_refused():
    run = replace(run_of(), measurements=(measured(None, 0.0, 0.1),))
    with pytest.raises(DataError, match="no recordings to analyse"):
        analysed(run, analysis_spec=THIS_RUN)


def test_procedure_is_required_unless_this_run():
    spec = SwingTorque.model_validate({"no_load": {"from": "this run"}})
    assert spec.no_load.is_this_run
    with pytest.raises(ValueError, match="the key 'procedure' is missing, or 'from: this run'"):
        SwingTorque.model_validate({"no_load": {"from": "latest"}})


def labelled(hertz, load_n, torque_nm, **coordinates):
    return replace(measured(hertz, load_n, torque_nm), coordinates=coordinates)


def test_different_labels_are_not_averaged():
    run = tables()
    worn = labelled(10.0, 1000.0, 2.5, phase="wear")
    both_labels = replace(run, measurements=(*run.measurements, worn))
    with pytest.raises(DataError, match="would be averaged: no label; phase wear"):
        analysed(both_labels, analysis_spec=THIS_RUN)


def test_where_selects_analysed_data():
    """`where` excludes the worn one at 10 Hz, which has 0.3 N·m more, from the mean."""
    final = [replace(row, coordinates={"phase": "final"}) for row in tables().measurements]
    worn = labelled(10.0, 1000.0, no_load_nm(10.0) + 1.0, phase="wear", block=1)
    run = replace(run_of(), measurements=(*final, worn))
    spec = THIS_RUN.model_copy(update={"where": {"phase": "final"}})
    result = analysed(run, analysis_spec=spec)
    assert [
        point.torque.value for point in TorqueDetails.of(result).compensations[spec.primary].points
    ] == (pytest.approx([0.7] * 4))
    assert result.run.measurements is run.measurements
