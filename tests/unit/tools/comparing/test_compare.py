"""Only the changes between procedures or runs are reported, in words."""

from __future__ import annotations

import re
from math import hypot, sqrt

import numpy as np
import pytest

from helpers_workflow import START, edited, quick_procedure, run, station_file
from rigrunner.api.errors import UsageError
from rigrunner.clock import SimulatedClock
from rigrunner.run.locate import find_procedure
from rigrunner.runfile import read
from rigrunner.tools.comparing.compare import compare
from rigrunner.tools.comparing.procedures import ProcedureTexts, procedure_changes
from rigrunner.tools.comparing.results import result_changes
from rigrunner.tools.comparing.tree import changes, same

LOADED = find_procedure("starting_torque_1000n")
TEXT = """\
rigrunner: procedure/2
id: TEST
revision: "A"
title: A test
measurand: {symbol: Td, name: load-induced starting torque, unit: N·m}
inputs:
  operator: {ask: Your name}
uses: {tester: swing_tester}
parameters:
  load: 1000 N
  frequencies: [1 Hz, 3 Hz, 5 Hz, 33 Hz, 35 Hz]
setup:
  - set: {tester.frequency: 5 Hz}
  - confirm: {text: Guards closed.}
  - settle: {cycles: 100} # running-in
main:
  - set: {tester.load: $load}
  - sweep:
      set: tester.frequency
      over: $frequencies
      steps:
        - settle: {cycles: 5}
        - record: {channels: [tester.angle, tester.torque], cycles: 30}
teardown:
  - set: {tester.frequency: 0 Hz}
  - set: {tester.load: 0 N}
analysis:
  - swing_torque:
      no_load: {from: latest, procedure: OTHER, max_age: 8 h, same: [station, mandrel]}
      despike: {hampel: {window: 11}}
      fits:
        - polynomial: {degree: 2}
        - inertia_physical
      compensations:
        - paper_peak: {coefficients: refit}
        - template_inverse
        - energy
      primary: template_inverse
acceptance:
  limits: [{of: torque, mean: yes, max: 0.95 N·m, source: demonstration only,
    measurand: {nature: load_induced, condition: at_reversal, load: 1 kN}}]
  rule: guard_band_u
"""

# old text, new text, section, message
EDITS = [
    ("max: 0.95 N·m", "max: 900 mN·m", "acceptance",
     "limits 1 > max was lowered from 0.95 N·m to 900 mN·m"),
    ("max: 0.95 N·m, source", "max: 0.95 N·m, min: 0.1 N·m, source", "acceptance",
     "limits 1 > min was added: 0.1 N·m"),
    ("rule: guard_band_u", "rule: simple", "acceptance",
     "rule was changed from 'guard_band_u' to 'simple'"),
    ("load: 1000 N", "load: 1.2 kN", "parameters", "load was raised from 1000 N to 1.2 kN"),
    ("33 Hz, 35 Hz]", "35 Hz, 37 Hz]", "set-points", "frequencies: 37 Hz added; 33 Hz removed"),
    ("1 Hz, 3 Hz,", "3 Hz, 1 Hz,", "set-points",
     "frequencies: the same values in another order"),
    ("        - energy\n", "", "analysis", "swing_torque > compensations > energy was removed"),
    ("        - energy\n", "        - energy\n        - model_inverse\n", "analysis",
     "swing_torque > compensations > model_inverse was added"),
    ("        - template_inverse\n", "        - template_inverse: {support_load_dependence: 2 %}\n",
     "analysis",
     "swing_torque > compensations > template_inverse > support_load_dependence was added: 2 %"),
    ("        - polynomial: {degree: 2}\n        - inertia_physical\n",
     "        - inertia_physical\n        - polynomial: {degree: 2}\n",
     "analysis", "swing_torque > fits: now in the order inertia_physical, polynomial"),
    ("primary: template_inverse", "primary: energy", "analysis",
     "swing_torque > primary was changed from 'template_inverse' to 'energy'"),
    ("max_age: 8 h", "max_age: 4 h", "analysis",
     "swing_torque > no_load > max_age was lowered from 8 h to 4 h"),
    ("settle: {cycles: 100}", "settle: {cycles: 50}", "setup",
     "step 3 > settle > cycles was changed from 100 to 50"),
    ("cycles: 30}", "cycles: 20}", "main",
     "step 2 > sweep > step 2 > record > cycles was changed from 30 to 20"),
    ("  - settle: {cycles: 100} ", "  - wait: {time: 2 s}\n  - settle: {cycles: 100} ", "setup",
     "setup: number 3 was added: {wait: {time: 2 s}}"),
    ("teardown:\n  - set: {tester.frequency: 0 Hz}\n", "teardown:\n", "teardown",
     "teardown: number 1 was removed: {set: {tester.frequency: 0 Hz}}"),
    ("Your name", "His name", "inputs",
     "operator > ask was changed from 'Your name' to 'His name'"),
    ('revision: "A"', 'revision: "B"', "revision", "revision was changed from 'A' to 'B'"),
]  # fmt: skip


def listed_changes(before, after, called=(), called_after=()):
    pair = (
        ProcedureTexts("a.yaml", before, dict(called)),
        ProcedureTexts("b.yaml", after, dict(called_after)),
    )
    return [(change.section, change.text) for change in procedure_changes(*pair)]


@pytest.mark.parametrize("edit", EDITS, ids=lambda edit: edit[1][:30])
def test_each_edit_is_one_change(edit):
    old, new, section, text = edit
    assert TEXT.count(old) == 1
    assert listed_changes(TEXT, TEXT.replace(old, new)) == [(section, text)]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("load: 1000 N", "load: 1 kN"),
        ("  load: 1000 N\n", "  load: 1000 N # a remark\n\n"),
        ("max: 0.95 N·m, source: demonstration only", "source: demonstration only, max: 950 mN·m"),
        ("{hampel: {window: 11}}", "\n        hampel:\n          window: 11"),
        ("max_age: 8 h, ", ""),
    ],
)
def test_equivalent_text_is_no_change(old, new):
    assert TEXT.count(old) == 1
    assert listed_changes(TEXT, TEXT.replace(old, new)) == []


def test_called_procedures_are_compared():
    before, after = {"a.yaml": TEXT, "b.yaml": TEXT}, {"b.yaml": TEXT.replace("30}", "9}")}
    assert listed_changes(TEXT, TEXT, before, after) == [
        ("called procedures", "a.yaml is no longer called"),
        (
            "called procedures",
            "b.yaml: main: step 2 > sweep > step 2 > record > cycles was changed from 30 to 9",
        ),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("one", "other", "equal"),
    [("1 kN", "1000 N", True), ("20 °C", "293.15 K", True), ("1 N", "1 N·m", False),
     ("5", 5, False), ({"a": 1, "b": 2}, {"b": 2, "a": 1}, True), ([1, 2], [2, 1], False),
     (None, {}, False), (True, 1, False)],
)  # fmt: skip
def test_equal_quantities_and_mappings_are_the_same(one, other, equal):
    assert same(one, other) is equal
    assert bool(list(changes("x", one, other))) is not equal


AT = {"set_frequency": {"value": 8.0, "unit": "Hz"}}


def estimate(value, expanded=0.03):
    return {"value": value, "expanded_uncertainty_95": expanded, "unit": "N·m"}


def document(value, expanded=0.03, verdict="pass"):
    return {
        "measurand": {"name": "torque"},
        "decision": {"verdict": verdict},
        "headline": {"method": "m", "compensated": estimate(value, expanded)},
        "compensations": {"m": {"points": [{**AT, "torque": estimate(value + 1, expanded)}]}},
        "points": [AT],
    }


def test_tiny_negative_difference_is_shown_as_plus_zero():
    shown = next(result_changes(document(0.70001), document(0.7)))
    assert ": +0.0000 N·m, within" in shown.text


def test_results_are_compared_against_their_combined_uncertainty():
    # E_n = 0.05 / sqrt(0.03² + 0.04²) = 1: the limit, which still agrees (ISO 13528, 9.7)
    near, far = document(0.75, 0.04), document(0.7505, 0.04)
    agreeing = list(result_changes(document(0.7), near))
    assert [change.matters for change in agreeing] == [False, False]
    assert "+0.0500 N·m, within their combined U of 0.0500 N·m (E_n = 1.00)" in agreeing[0].text
    assert agreeing[1].text.startswith("at 8 Hz: 1.7000 and 1.7500 N·m")
    differing = list(result_changes(document(0.7), far))
    assert all(change.matters for change in differing)
    assert "beyond their combined U" in differing[0].text
    assert list(result_changes(near, near)) == []


def test_difference_barely_beyond_u_is_shown_with_more_digits():
    # E_n = 0.0502 / sqrt(0.03² + 0.04²) = 1.004, and 1.000004
    (change, _) = result_changes(document(0.7), document(0.7502, 0.04))
    assert change.matters
    assert "+0.0502 N·m, beyond their combined U of 0.0500 N·m (E_n = 1.004)" in change.text
    (change, _) = result_changes(document(0.7), document(0.7500002, 0.04))
    assert change.matters
    assert change.text.endswith(
        "+0.0500002 N·m, beyond their combined U of 0.0500000 N·m (E_n = 1.000004)"
    )


def test_repeated_frequencies_are_compared_in_order():
    def twice(first, second):
        content = document(0.7)
        content["compensations"]["m"]["points"] = [
            {**AT, "torque": estimate(value)} for value in (first, second)
        ]
        return content | {"points": 2 * content["points"]}

    (change,) = result_changes(twice(1.0, 1.5), twice(2.0, 1.5))
    assert change.text.startswith("at 8 Hz: 1.0000 and 2.0000 N·m")
    assert change.matters
    (change,) = result_changes(twice(1.0, 1.5), twice(1.0, 2.5))
    assert change.text.startswith("at 8 Hz (2): 1.5000 and 2.5000 N·m")


def test_uncertainty_from_scatter_alone_is_stated_for_either_run():
    peak = {"mean": estimate(1.9), "cycles_kept": 10, "standard_deviation": {"value": 0.1}}
    raw = document(0.7) | {"compensations": {}}
    raw["points"] = [{**raw["points"][0], "raw_peak": peak}]
    for pair in ((raw, document(0.7)), (document(0.7), raw)):
        (change,) = result_changes(*pair)
        assert change.text.startswith("at 8 Hz: ")
        assert "their combined U from scatter alone of" in change.text


def test_missing_uncertainty_is_no_agreement():
    (headline, _) = result_changes(document(0.7), document(0.71, None))
    assert headline.matters
    assert "not known" in headline.text


def named(value, expanded, unit, at=None, name="gain"):
    estimated = {"value": value, "unit": unit, "expanded_uncertainty_95": expanded}
    places = (
        {} if at is None else {"coordinates": {"source.current": {"value": at[0], "unit": at[1]}}}
    )
    return document(0.7) | {"results": [{"name": name, "estimate": estimated, **places}]}


def test_results_in_two_units_are_compared_in_one():
    # 5.000 V and 5.001 V, U = 0.010 V each: E_n = 0.001 / (0.010 sqrt 2) = 0.0707
    (change,) = result_changes(named(5.0, 0.01, "V"), named(5001.0, 10.0, "mV"))
    assert change.text == (
        "gain: 5000 and 5001 mV: +1 mV, within their combined U of 14 mV (E_n = 0.07)"
    )
    assert not change.matters
    assert list(result_changes(named(20.0, 0.1, "°C"), named(293.15, 0.1, "K"))) == []
    (change,) = result_changes(named(5.0, 0.01, "V"), named(5.0, 0.01, "A"))
    assert change.text == "gain is in V and in A"


def line(name, u, contribution, unit="V"):
    of_input = {"value": u, "unit": "1" if name.startswith("gain") else "V"}
    sensitivity = {"value": contribution / u, "unit": "V"}
    return {
        "name": name, "standard_uncertainty": of_input, "sensitivity": sensitivity,
        "degrees_of_freedom": "infinite", "distribution": "rectangular",
        "contribution": {"value": abs(contribution), "unit": unit},
    }  # fmt: skip


def measured(value, unit="V"):
    """Return a reading in volts: gain within 1 %, offset within 50 mV, resolution within 10 mV."""
    volt, width = (1.0 if unit == "V" else 1e3), sqrt(3)
    lines = [
        line("gain of meter.voltage (K-1)", 0.01 / width, 0.01 * value * volt / width, unit),
        line("offset of meter.voltage", 0.05 / width, 0.05 * volt / width, unit),
        line("resolution of meter.voltage", 0.01 / width, 0.01 * volt / width, unit),
    ]
    u = hypot(*(entry["contribution"]["value"] for entry in lines))
    content = named(value * volt, 1.7 * u, unit)
    content["results"][0]["estimate"]["standard_uncertainty"] = u
    content["results"][0]["budget"] = lines
    return content


def test_shared_meter_errors_are_excluded_from_the_difference():
    """Two readings that differ by 50 mV, more than the resolution of the meter explains."""
    rng, count = np.random.default_rng(1), 400_000
    gain, one, other = rng.uniform(-1, 1, (3, count)) * np.array([[0.01], [0.01], [0.01]])
    expanded = np.quantile(np.abs(10.05 * gain + other - 10 * gain - one), 0.95)
    (change,) = result_changes(measured(10.0), measured(10.05), {"meter.voltage"})
    assert change.matters
    ratio = float(re.search(r"E_n = ([\d.]+); one error of both: gain of", change.text)[1])
    assert ratio == pytest.approx(0.05 / expanded, rel=0.02)
    (in_millivolts,) = result_changes(measured(10.0), measured(10.05, "mV"), {"meter.voltage"})
    assert f"E_n = {ratio:.2f}" in in_millivolts.text
    (independent,) = result_changes(measured(10.0), measured(10.05), {"other.voltage"})
    assert not independent.matters  # another meter, or one calibrated between the runs
    assert "E_n = 0.32)" in independent.text  # 0.05/(1.7 sqrt 2 u)


def test_coordinates_in_two_units_are_matched():
    first, second = named(1.0, 0.1, "V", (2.0, "A")), named(1.5, 0.1, "V", (2000.0, "mA"))
    (change,) = result_changes(first, second)
    assert change.text.startswith("gain at source.current = 2 A: 1.00 and 1.50 V")
    assert "E_n = 3.54" in change.text  # 0.5 / (0.1 sqrt 2)
    assert change.matters


def test_result_of_only_one_run_matters():
    first, second = named(1.0, 0.1, "V", (2.0, "A")), named(1.0, 0.1, "V", (2.000001, "A"))
    changes = list(result_changes(first, second))
    assert [change.text for change in changes] == [
        "gain at source.current = 2 A is a result of the first run alone",
        "gain at source.current = 2 A is a result of the second run alone",
    ]
    assert all(change.matters for change in changes)


def test_different_verdict_matters():
    (change,) = result_changes(document(0.7), document(0.7, verdict="fail"))
    assert change.text == "verdict was changed from 'pass' to 'fail'"
    assert [change.text for change in result_changes(None, document(0.7))] == [
        "the second run alone has a result"
    ]
    assert [change.text for change in result_changes(document(0.7), None)] == [
        "the first run alone has a result"
    ]
    assert list(result_changes(None, None)) == []


def test_added_method_is_reported():
    without_method = document(0.7) | {"compensations": {}}
    without_method["headline"] = {"method": None, "compensated": estimate(0.7)}
    assert next(result_changes(without_method, document(0.7))).text == "method was added: 'm'"


def test_measured_values_are_compared_by_their_verdicts():
    def limited(verdict):
        values = [{"table": "cell", "row": 1, "of": "tester.load", "verdict": verdict}]
        return document(0.7) | {"limits": {"values": values}}

    (change,) = result_changes(limited("pass"), limited("fail"))
    assert change.text == "tester.load in cell 1 was changed from 'pass' to 'fail'"
    (change,) = result_changes(limited("fail"), document(0.7))
    assert change.text == "tester.load in cell 1 was changed from 'fail' to 'not measured'"
    assert list(result_changes(limited("fail"), limited("fail"))) == []


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("diff")
    procedure = quick_procedure(folder, "no_load_inertia_sweep")
    first = run(procedure, folder / "runs", clock=SimulatedClock(START))
    station = station_file(
        folder, ("{seed: 1}", "{seed: 2}"), ("gain: 0.3 %", "gain: 0.5 %"), ("M-01", "M-02")
    )
    shorter = edited(procedure, folder / "b.yaml", cycles=("cycles: 12}", "cycles: 10}"))
    second = run(shorter, folder / "runs", station=station, clock=SimulatedClock(START))
    return folder / "runs", first.folder, second.folder


def test_two_runs_are_compared_by_procedure_station_and_results(runs):
    folder, first, second = runs
    comparison = compare(str(first), second.name, folder)
    texts = {(change.section, change.text) for change in comparison.changes}
    assert ("main", "step 1 > sweep > step 2 > record > cycles was changed from 12 to 10") in texts
    assert (
        "instruments", "tester.torque > accuracy > gain was raised from 0.3 % to 0.5 %"
    ) in texts  # fmt: skip
    assert ("station, rig", "mandrel was changed from 'M-01' to 'M-02'") in texts
    assert ("station, devices", "tester > settings > seed was changed from 1 to 2") in texts
    assert any(section == "results" and "at 35 Hz" in text for section, text in texts)
    assert not comparison.same


def test_results_come_first_then_relevant_sections(runs):
    folder, first, second = runs
    differences = compare(str(first), second.name, folder).changes
    sections = list(dict.fromkeys(change.section for change in differences))
    assert sections[0] == "results"
    assert len(sections) > 2
    for section in sections:
        weights = [change.matters for change in differences if change.section == section]
        assert weights == sorted(weights, reverse=True)
    heavy = [any(e.matters for e in differences if e.section == s) for s in sections[1:]]
    assert heavy == sorted(heavy, reverse=True)


def test_run_is_the_same_as_itself(runs):
    folder, first, _ = runs
    comparison = compare(str(first), str(first / "run.h5"), folder)
    assert (comparison.changes, comparison.same) == ((), True)
    assert read(first).header.run_id in comparison.before


def test_incomparable_arguments_are_refused(runs, tmp_path):
    folder, first, _ = runs
    with pytest.raises(UsageError, match=r"is a procedure, and .* is a run"):
        compare(str(LOADED), str(first), folder)
    with pytest.raises(UsageError, match="there is no procedure and no run 'nothing'"):
        compare(str(LOADED), "nothing", folder)
    with pytest.raises(UsageError, match="there is no procedure and no run 'nothing'"):
        compare("nothing", "other", tmp_path)


def test_change_of_layout_is_distinguished_from_identity(tmp_path):
    copy = tmp_path / "other.yaml"
    shipped = LOADED.read_text(encoding="utf-8")
    copy.write_text(f"{shipped}\n# a remark\n", encoding="utf-8")
    assert "layout" in compare(str(LOADED), str(copy), tmp_path).verdict
    assert "the texts are the same" in compare(str(LOADED), str(LOADED), tmp_path).verdict


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        (["1 Hz", "2 Hz", "2 Hz"], ["2 Hz", "1 Hz"], "over: 2 Hz removed"),
        (["1 Hz"], ["1000 mHz", "1 Hz", "3 Hz"], "over: 1 Hz, 3 Hz added"),
        (["1 Hz", "2 Hz"], ["2 Hz", "1 Hz"], "over: the same values in another order"),
    ],
)
def test_repeated_values_are_counted_in_list_changes(before, after, text):
    assert [change.text for change in changes("main", before, after, ("over",))] == [text]
