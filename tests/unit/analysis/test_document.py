from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from rigrunner.analysis.document import document
from rigrunner.api import Component, Estimate, MeasurementResult, ResultDefinition
from rigrunner.api.findings import Table
from rigrunner.api.instruments import Instrument
from rigrunner_bearings.api.torque import TorqueDetails
from unit.analysis.helpers_analysis import acceptance, analysed, recording, run_of, spec

SCATTER = np.array([0.01, -0.01, 0.0, 0.02, -0.02, 0.0, 0.01, -0.01, 0.005, -0.005])


def sweep(extra_nm, load_n):
    peaks = {f: 0.9 + 0.004 * f**2 + extra_nm + SCATTER for f in (2.0, 4.0, 6.0, 8.0, 10.0)}
    return run_of(*(recording(values, f, load_n=load_n) for f, values in peaks.items()))


@pytest.fixture(scope="module")
def result():
    return analysed(sweep(0.7, 1000.0), sweep(0.0, 0.0), accept=acceptance())


@pytest.fixture(scope="module")
def content(result):
    return document(result)


def test_document_is_json_without_nan_and_round_trips(content):
    text = json.dumps(content, allow_nan=False, ensure_ascii=False)
    assert json.loads(text) == content


def test_document_has_the_result_in_full_precision(result, content):
    headline = content["headline"]["compensated"]
    assert headline["value"] == result.headline.value
    assert headline["standard_uncertainty"] == result.headline.u
    assert headline["unit"] == "N·m"
    point = content["compensations"]["paper_peak"]["points"][3]
    expected = TorqueDetails.of(result).compensations["paper_peak"].points[3]
    assert point["torque"]["value"] == expected.torque.value
    assert point["raw"]["value"] - point["rig"]["value"] == point["torque"]["value"]
    assert len(point["budget"]) == len(expected.components)


def test_zeros_have_the_unit_of_their_quantity(result):
    cell = Instrument.model_validate(
        {"channel": "press.force", "measures": "force", "serial": "LC-3", "certificate": "D-1"}
    )
    gauge = replace(result.run.recordings[0], units={"press.gap": "m"})
    run = replace(
        result.run,
        instruments={"press.force": cell},
        zeros={"press.force": -0.25, "press.gap": 1e-3},
        recordings=(gauge,),
    )
    content = document(replace(result, run=run))["run"]

    assert content["zeros"] == {
        "press.force": {"value": -0.25, "unit": "N"},
        "press.gap": {"value": 1e-3, "unit": "m"},
    }
    assert content["instruments"] == {"press.force": {"serial": "LC-3", "certificate": "D-1"}}


def test_expanded_uncertainty_is_k_times_u(content):
    headline = content["headline"]["compensated"]
    k, u = headline["coverage_factor_95"], headline["standard_uncertainty"]
    assert headline["expanded_uncertainty_95"] == k * u
    assert 0.95 * 3**0.5 < k < 3  # between one rectangle and Student's t of a few cycles


def test_every_value_has_its_unit(content):
    def walk(node, path):
        if isinstance(node, dict):
            assert "value" not in node or "unit" in node, path
            assert "values" not in node or "unit" in node, path
            for key, child in node.items():
                walk(child, (*path, key))
        elif isinstance(node, list):
            for index, child in enumerate(node):
                walk(child, (*path, index))

    walk(content, ())


def test_document_names_both_runs(content):
    assert content["run"]["digest_sha256"] == "ab" * 32
    assert content["run"]["procedure"]["id"] == "SSPB-STT-1000"
    assert content["no_load_run"]["id"] == "run-1"


def test_document_contains_no_waveforms(content):
    assert len(json.dumps(content)) < 90_000


def test_torque_is_a_named_result_at_each_frequency(content):
    """Its coordinates are the set-points of the recordings; its values those of the points."""
    results = content["results"]
    assert {entry["name"] for entry in results} == {content["headline"]["name"]} == {"torque"}
    places = [entry["coordinates"] for entry in results]
    assert places == [{"frequency": {"value": f, "unit": "Hz"}} for f in (2.0, 4.0, 6.0, 8.0, 10.0)]
    points = content["compensations"]["paper_peak"]["points"]
    assert [entry["estimate"] for entry in results] == [entry["torque"] for entry in points]
    assert [entry["budget"] for entry in results] == [entry["budget"] for entry in points]
    assert results[0]["measurand"] == {
        "id": "load_induced.at_reversal",
        "text": "load-induced torque at the reversals of a swing",
    }


def test_missing_result_is_null_with_its_reason():
    content = document(analysed(sweep(0.7, 1000.0), None, spec(), acceptance()))
    assert content["headline"]["compensated"] is None
    assert content["decision"]["probability_of_conformity"] is None
    assert "needs a no-load run" in content["decision"]["reason"]
    assert "needs a no-load run" in content["compensations"]["paper_peak"]["not_applicable"]
    assert content["no_load_run"] is None
    json.dumps(content, allow_nan=False)


def test_infinite_degrees_of_freedom_are_text(content):
    budget = content["compensations"]["paper_peak"]["points"][0]["budget"]
    assert {part["degrees_of_freedom"] for part in budget} >= {9.0, 2.0, "infinite"}
    assert content["decision"]["lower_limit"] == {"value": None, "unit": "N·m"}
    assert content["decision"]["upper_limit"] == {"value": 0.95, "unit": "N·m"}


def test_numpy_scalars_become_json_numbers(result):
    """They come from counted readings or compared arrays; a run with them could not be sealed."""
    line = Component("x", np.float64(0.1), np.int64(9), "t", common=np.bool_(1))
    drop = MeasurementResult(
        of=ResultDefinition(name="drop", unit="mV"),
        estimate=Estimate(np.float32(0.5), np.float64(0.1), np.int64(9), "mV"),
        components=(line,),
        readings=np.int64(2),
    )
    table = Table(of="drop", title="T", columns=("n", "x"), rows=((np.int64(3), np.float32(0.5)),))
    content = document(replace(result, results=(drop,), details=(), tables=(table,)))
    text = json.dumps({key: content[key] for key in ("results", "tables")}, allow_nan=False)
    assert json.loads(text)["results"][0]["readings"] == 2
    assert json.loads(text)["tables"][0]["rows"] == [[3, 0.5]]
