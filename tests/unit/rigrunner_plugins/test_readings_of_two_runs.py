"""`readings` minus or over those of a partner run, against the sums of the GUM by hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import hypot, sqrt

import numpy as np
import pytest

from rigrunner.analysis.named import findings_of
from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.analysis.verdict.limited_values import mean_of
from rigrunner.api.errors import DataError, PluginError
from rigrunner.api.instruments import Instrument
from rigrunner.procedure import AnalysisRef
from rigrunner.registry import load_registry
from unit.rigrunner_plugins.test_readings import analyse, row, run_of

SQRT3 = sqrt(3)


def meter(**accuracy) -> Instrument:
    settings = {"channel": "meter.voltage", "measures": "voltage", "serial": "M-1"}
    return Instrument.model_validate({**settings, "accuracy": accuracy or "30 mV"})


def voltages(*values, instrument=None):
    rows = [row(i, 1.0, meter__voltage=value) for i, value in enumerate(values)]
    return run_of(*rows, instruments=[instrument or meter()])


def compare(run, partner, name="tare", **settings):
    return analyse(replace(run, partners={name: partner}), **settings)


def budget(findings):
    (result,) = findings.results
    return result.estimate, {line.name: line for line in result.components}


def test_tare_is_subtracted_and_the_offset_of_the_same_meter_cancels():
    instrument = meter(offset="30 mV", gain="0.1 %")
    run, dark = voltages(5.1, 5.3, instrument=instrument), voltages(0.2, 0.2, instrument=instrument)
    estimate, lines = budget(compare(run, dark, tare={"procedure": "DARK"}))
    assert estimate.value == pytest.approx(5.0)
    assert lines["offset of meter.voltage"].u == pytest.approx(0.0, abs=1e-9)
    # the gain is off by 0.1 % of the difference, rectangular (GUM 4.3.7)
    assert lines["gain of meter.voltage"].u == pytest.approx(0.001 * 5.0 / SQRT3, rel=1e-5)
    assert lines["scatter of the readings"].u == pytest.approx(0.1, rel=1e-9)
    assert "scatter of the readings of meter.voltage, tare run" in lines
    assert estimate.u == pytest.approx(sqrt(0.1**2 + (0.005 / SQRT3) ** 2), rel=1e-5)


def test_gain_of_the_same_meter_cancels_over_a_reference():
    instrument = meter(offset="30 mV", gain="1 %")
    run, reference = voltages(6.0, instrument=instrument), voltages(2.0, instrument=instrument)
    findings_ = compare(run, reference, "reference", unit="1", relative_to={"procedure": "REF"})
    estimate, lines = budget(findings_)
    assert estimate.value == pytest.approx(3.0)
    assert lines["gain of meter.voltage"].u == pytest.approx(0.0, abs=1e-9)
    # d(a/b) of one offset e of both: e/b - a e/b^2 = e (1/2 - 6/4)
    assert lines["offset of meter.voltage"].u == pytest.approx(0.030 / SQRT3, rel=1e-5)


def test_reference_of_0_makes_the_result_missing_with_the_reason():
    settings = {"unit": "1", "relative_to": {"procedure": "REF"}}
    findings_ = compare(voltages(6.0), voltages(0.0), "reference", **settings)
    assert findings_.results == ()
    (missing,) = findings_.missing
    assert missing.why == "the value of the reference run is 0, and nothing can be divided by it"


def test_accuracy_in_one_figure_counts_in_both_runs():
    estimate, lines = budget(compare(voltages(5.0), voltages(1.0), tare={"procedure": "DARK"}))
    assert set(lines) == {"reading of meter.voltage", "reading of meter.voltage, tare run"}
    assert estimate.u == pytest.approx(sqrt(2) * 0.030 / SQRT3, rel=1e-6)


@pytest.mark.parametrize("change", [{"serial": "M-2"}, {"certificate": "C-2"}])
def test_another_meter_or_calibration_shares_no_error(change):
    instrument = meter(offset="30 mV")
    run = voltages(5.0, instrument=instrument)
    dark = voltages(1.0, instrument=instrument.model_copy(update=change))
    estimate, lines = budget(compare(run, dark, tare={"procedure": "DARK"}))
    assert len(lines) == 2
    assert estimate.u == pytest.approx(sqrt(2) * 0.030 / SQRT3, rel=1e-5)


def test_values_are_compared_at_equal_places_in_any_order():
    run = run_of(row(0, 1.0, meter__voltage=5.0), row(1, 2.0, meter__voltage=7.0))
    dark = run_of(row(0, 2.0, meter__voltage=2.0), row(1, 1.0, meter__voltage=1.0))
    tare = {"procedure": "DARK", "per": "load.current"}
    results = compare(run, dark, per="load.current", tare=tare).results
    assert [result.estimate.value for result in results] == [4.0, 5.0]
    common_tare = compare(run, dark, per="load.current", tare={"procedure": "DARK"}).results
    assert [result.estimate.value for result in common_tare] == [3.5, 5.5]
    incomplete = run_of(row(0, 2.0, meter__voltage=2.0))
    with pytest.raises(DataError, match=r"the tare run, r, has nothing at load.current = 1"):
        compare(run, incomplete, per="load.current", tare=tare)


ZERO = (0.2, -0.1, 0.3)
U_ZERO = float(np.std(ZERO, ddof=1)) / SQRT3
NET = {"of": "meter.voltage", "per": ["load.current"], "tare": {"procedure": "DARK"},
       "result": {"name": "net", "unit": "mV"}}  # fmt: skip
AMPERES = (1.0, 2.0, 3.0, 4.0)


def results(*analyses, dark):
    rows = [row(i, at, meter__voltage=at + off) for i, (at, off) in enumerate(NOISY)]
    run = replace(run_of(*rows, instruments=[meter(offset="0 V")]), partners={"tare": dark})
    references = [AnalysisRef.model_validate({name: settings}) for name, settings in analyses]
    all_findings = findings_of(run, references, Scrutiny(load_registry()))
    return [result for findings in all_findings for result in findings.results]


NOISY = [(at, off) for at in AMPERES for off in (0.01, -0.01)]
U_READINGS = 0.01  # of the mean of two that are 0.02 V apart


def test_scatter_of_a_tare_is_one_error_of_all_results():
    """Three readings of a zero: their scatter neither averages out nor scatters about a curve."""
    dark = voltages(*ZERO, instrument=meter(offset="0 V"))
    line = {"of": "net", "over": "load.current", "fit": {"polynomial": {"degree": 1}},
            "results": {"slope": {"name": "slope", "unit": "V/A"},
                        "parameters": {"c0": {"name": "level", "unit": "V"}}}}  # fmt: skip
    sum_of = {"model": "a + 2 * b", "inputs": {"a": "net", "b": "level"}, "per": ["load.current"],
              "result": {"name": "sum", "unit": "V"}}  # fmt: skip
    all_results = results(("readings", NET), ("curve", line), ("equation", sum_of), dark=dark)
    nets = [result for result in all_results if result.name == "net"]
    assert nets[0].estimate.u == pytest.approx(1e3 * hypot(U_ZERO, U_READINGS))
    mean = mean_of(nets)
    assert mean.u == pytest.approx(1e3 * hypot(U_ZERO, U_READINGS / 2))
    assert mean.dof == pytest.approx(2, rel=0.01)
    (slope,) = (result for result in all_results if result.name == "slope")
    (level,) = (result for result in all_results if result.name == "level")
    assert slope.estimate.u == pytest.approx(0, abs=1e-6)  # all points move together
    assert level.estimate.u == pytest.approx(U_ZERO, rel=1e-5)
    sums = [result for result in all_results if result.name == "sum"]
    assert sums[0].estimate.u == pytest.approx(hypot(3 * U_ZERO, U_READINGS), rel=1e-4)


def test_scatter_of_a_tare_per_place_is_independent_at_each_place():
    rows = [row(i, at, meter__voltage=off) for i, (at, off) in enumerate(product(AMPERES, ZERO))]
    dark = run_of(*rows, instruments=[meter(offset="0 V")])
    settings = {**NET, "tare": {"procedure": "DARK", "per": "load.current"}}
    twice = {"model": "a + b", "inputs": {"a": "net", "b": "again"}, "per": ["load.current"],
             "result": {"name": "sum", "unit": "V"}}  # fmt: skip
    again = {**settings, "result": {"name": "again", "unit": "V"}}
    all_results = results(
        ("readings", settings), ("readings", again), ("equation", twice), dark=dark
    )
    nets = [result for result in all_results if result.name == "net"]
    assert mean_of(nets).u == pytest.approx(1e3 * hypot(U_ZERO, U_READINGS) / 2)
    sums = [result for result in all_results if result.name == "sum"]
    # it is not known that both use the same readings of this run
    assert sums[0].estimate.u == pytest.approx(hypot(2 * U_ZERO, sqrt(2) * U_READINGS))


def test_scatter_of_a_reference_acts_through_each_quotient():
    reference = voltages(2.1, 1.9, 2.0, instrument=meter(offset="0 V"))
    settings = {"of": "meter.voltage", "per": "load.current", "relative_to": {"procedure": "REF"}}
    rows = [row(i, at, meter__voltage=at - 2.5) for i, at in enumerate(AMPERES)]
    run = run_of(*rows, instruments=[meter(offset="0 V")])
    results = compare(run, reference, "reference", unit="1", **settings).results
    effects = [(at - 2.5) / 2.0**2 * 0.1 / SQRT3 for at in AMPERES]
    assert [result.estimate.u for result in results] == pytest.approx(
        [abs(effect) for effect in effects]
    )
    assert mean_of(results).u == pytest.approx(abs(sum(effects)) / 4, abs=1e-12)  # it cancels


def test_tare_of_another_specimen_is_reported():
    run, dark = (
        replace(voltages(value), inputs={"specimen": name}, run_id=name)
        for value, name in ((5.0, "SN-1"), (1.0, "SN-2"))
    )
    settings = {"tare": {"procedure": "DARK"}}
    note = "found: the tare run, SN-2, is of specimen SN-2, and this run of SN-1."
    assert note in compare(run, dark, **settings).notes
    same = replace(dark, inputs=run.inputs)
    assert not [note for note in compare(run, same, **settings).notes if "specimen" in note]


def test_required_partner_run_is_known_from_the_settings():
    settings = {
        "of": "meter.voltage",
        "per": "load.current",
        "result": {"name": "net", "unit": "V"},
        "tare": {
            "name": "dark",
            "procedure": "DARK",
            "max_age": "1 h",
            "same": ["station"],
            "per": "load.current",
        },
    }
    (needed,) = load_registry().requires("analysis", "readings", settings).partners
    assert (needed.name, needed.key, needed.procedure) == ("dark", ("tare",), "DARK")
    assert (needed.max_age_s, needed.same, needed.at) == (3600.0, ("station",), ("load.current",))
    assert [channel.name for channel in needed.channels] == ["meter.voltage"]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"tare": {}, "relative_to": {}}, "one of 'tare' and 'relative_to'"),
        ({"tare": {"per": "load.current"}}, "'per' names coordinates of the analysis' own"),
        ({"tare": {"name": "station"}}, "cannot be the name of a partner run"),
        ({"tare": {"name": "a b"}}, "name"),
    ],
)
def test_contradictory_settings_are_refused(settings, words):
    common = {"of": "meter.voltage", "result": {"name": "net", "unit": "V"}}
    with pytest.raises(PluginError, match=words):
        load_registry().requires("analysis", "readings", common | settings)
