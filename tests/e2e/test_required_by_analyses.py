"""Requirements of analyses are checked before anything moves, each with its line."""

from __future__ import annotations

import json

import pytest

from helpers_any_quantity import written
from helpers_cli import call
from rigrunner.run.locate import find_procedure

PROCEDURE = """\
rigrunner: procedure/2
id: PSU-TWO
revision: "A"
title: Regulation of a power supply, of its own results
inputs: {specimen: {ask: Serial number, unattended: PSU-1}}
uses: {bench: supply_bench}
main:
  - sweep:
      set: bench.current
      over: [0 A, 1 A, 2 A, 5 A]
      label: {way: up}
      steps:
        - measure: {channels: [bench.voltage, bench.ripple]}
analysis:
  - equation:
      result: {name: regulation, text: load regulation, unit: "%"}
      model: (none - full) / none
      inputs: {none: idle, full: loaded}
  - readings: {of: bench.voltage, where: {bench.current: 0 A}, result: {name: idle, unit: V}}
  - readings: {of: bench.voltage, where: {bench.current: 5 A}, result: {name: loaded, unit: V}}
  - readings: {of: bench.voltage, per: bench.current, result: {name: voltage, unit: V}}
  - equation:
      result: {name: share, unit: "%"}
      per: bench.current
      model: U / none
      inputs: {U: voltage, none: idle}
acceptance:
  rule: guard_band_u
  limits:
    - {of: regulation, max: 0.5 %, source: data sheet}
    - {of: share, each: bench.current, min: 99 %, source: data sheet}
"""
CURVE = """
  - curve:
      of: bench.voltage
      over: bench.current
      fit: {polynomial: {degree: 1}}
      results: {value: {name: at, at: 4 A, unit: V}}
"""
OF_RESULTS = """
  - curve:
      of: share
      over: bench.current
      fit: {polynomial: {degree: 1}}
      results: {value: {name: at, at: 4 A, unit: "%"}}
"""
FORMULA = CURVE.replace(
    "{polynomial: {degree: 1}}",
    "{expression: {over: [i], model: U - r*i, start: {U: 12 V, r: 9 mA}}}",
).replace("{value", "{parameters: {r: {name: r, unit: mΩ}}, value")
HYSTERESIS = "{hysteresis: {name: h, unit: mV, between: {way: [up, dwn]}}"
HERE = "per: bench.current, result: {name: voltage"


IDLE = next(each for each in PROCEDURE.splitlines(keepends=True) if "name: idle" in each)


def check_changed(folder, *changes):
    procedure, station = written(folder, *changes, procedure=PROCEDURE)
    return call("check", procedure, "--station", station)


def line_of(text, folder):
    lines = (folder / "supply.yaml").read_text(encoding="utf-8").splitlines()
    return next(index for index, line in enumerate(lines, 1) if text in line)


def test_results_of_results_are_computed_limited_and_reported(tmp_path):
    procedure, station = written(tmp_path, procedure=PROCEDURE)
    called = call("run", procedure, "--station", station, "--unattended", "--runs", tmp_path / "r")
    assert called.code == 0, called.err
    (folder,) = (tmp_path / "r").iterdir()
    results = json.loads((folder / "result.json").read_text(encoding="utf-8"))["results"]
    (regulation,) = [result["estimate"] for result in results if result["name"] == "regulation"]
    assert regulation["value"] == pytest.approx(100 * (12.031 - 11.987) / 12.031)
    u = 100 * 0.002 / 3**0.5 * (2 / 12.031**2) ** 0.5  # of two readings, each within 2 mV
    assert regulation["standard_uncertainty"] == pytest.approx(u, rel=0.01)
    shares = [result["estimate"]["value"] for result in results if result["name"] == "share"]
    assert shares == pytest.approx([100 * v / 12.031 for v in (12.031, 12.022, 12.014, 11.987)])
    assert "load regulation" in (folder / "report.html").read_text(encoding="utf-8")
    assert call("verify", folder).code == 0


@pytest.mark.parametrize(
    ("old", "new", "at", "message"),
    [
        ("full: loaded", "full: loadet", "full: loadet", "there is no result 'loadet'"),
        (
            "of: bench.voltage, where: {bench.current: 0 A}, result: {name: idle",
            "of: bench.voltage, per: bench.current, result: {name: idle",
            "full: loaded",
            "there is a result 'idle' for each bench.current",
        ),
        (
            IDLE,
            (
                "  - equation: {result: {name: idle, unit: V}, model: r * V,\n"
                "               inputs: {r: regulation, V: loaded}}\n"
            ),
            "none: idle, full",
            "is computed from this result itself",
        ),
        ("model: U / none", "model: U + none / none", "model: U + none", "a number"),
        (
            HERE,
            HERE.replace("voltage", "voltage, text: x").replace("bench.current", "[bench.voltage]"),
            "per: [bench.voltage]",
            "'bench.voltage' is not set at every",
        ),
        (
            "acceptance:",
            CURVE.replace("4 A", "6 A")[1:] + "acceptance:",
            "over: bench.current",
            "bench.current must reach 6 A, but is set 0 A to 5 A",
        ),
        (
            "acceptance:",
            CURVE.replace("degree: 1", "degree: 3")[1:] + "acceptance:",
            "fit: {",
            "the fit needs 5 different values of bench.current, got 4",
        ),
        (
            "acceptance:",
            CURVE.replace("{value", "{parameters: {a1: {name: r, unit: mV/A}}, value")[1:]
            + "acceptance:",
            "results: {parameters",
            "the fit has no parameter 'a1'",
        ),
        (
            "acceptance:",
            FORMULA[1:] + "acceptance:",
            "results: {parameters",
            "got 'mΩ', a resistance; the fit begins with it in A, a current",
        ),
        (
            "acceptance:",
            CURVE.replace("{value", HYSTERESIS + ", value")[1:] + "acceptance:",
            "results: {hysteresis",
            "nothing is measured at way = dwn",
        ),
        (
            "acceptance:",
            OF_RESULTS.replace("over: bench.current", "over: bench.ripple")[1:] + "acceptance:",
            "of: share",
            "there is no result 'share' for each bench.ripple",
        ),
        (
            "acceptance:",
            OF_RESULTS.replace("over: bench.current", "over: idle")[1:] + "acceptance:",
            "over: idle",
            "'idle' and 'share' have values at other places",
        ),
        (
            "acceptance:",
            OF_RESULTS.replace("4 A", "6 A")[1:] + "acceptance:",
            "over: bench.current",
            "bench.current must reach 6 A, but is set 0 A to 5 A",
        ),
        (
            "acceptance:",
            OF_RESULTS.replace('unit: "%"', "unit: V")[1:] + "acceptance:",
            "results: {value",
            "got 'V', a voltage; it is a ratio",
        ),
    ],
    ids=[
        "unknown",
        "per",
        "circle",
        "kind",
        "coordinate",
        "spans",
        "points",
        "parameter",
        "parameter's unit",
        "label",
        "coordinate of results",
        "other places",
        "spans of results",
        "kind of results",
    ],
)
def test_unmet_requirement_is_refused_with_its_line(tmp_path, old, new, at, message):
    called = check_changed(tmp_path, (old, new))
    assert called.code == 3, called.out
    assert message in called.err
    error = next(line for line in called.err.splitlines() if message in line)
    assert f"supply.yaml:{line_of(at, tmp_path)}:" in error


@pytest.mark.parametrize("curve", [CURVE, OF_RESULTS], ids=["readings", "results"])
def test_curve_within_its_set_points_is_accepted(tmp_path, curve):
    called = check_changed(tmp_path, ("acceptance:", curve[1:] + "acceptance:"))
    assert called.code == 0, called.err


def test_limited_curve_over_time_needs_no_instrument_for_it(tmp_path):
    """A counter is not a channel."""
    over_time = CURVE.replace("over: bench.current", "over: elapsed").replace("4 A", "0 s")
    limit = "    - {of: at, max: 20 V, source: data sheet}\n"
    text = PROCEDURE.replace("acceptance:", over_time[1:] + "acceptance:") + limit
    procedure, station = written(tmp_path, procedure=text)
    assert call("check", procedure, "--station", station).code == 0


def test_reading_as_x_needs_an_instrument_for_a_limited_result(tmp_path):
    """A set-point without an entry in the register is exact; a reading is not."""
    of_ripple = CURVE.replace("over: bench.current", "over: bench.ripple").replace("4 A", "4 mV")
    limit = "    - {of: at, max: 20 V, source: data sheet}\n"
    text = PROCEDURE.replace("acceptance:", of_ripple[1:] + "acceptance:") + limit
    procedure, station = written(tmp_path, procedure=text)
    lines = station.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = "".join(line for line in lines if "channel: bench.ripple" not in line)
    station.write_text(kept, encoding="utf-8")
    called = call("check", procedure, "--station", station)
    assert called.code == 3, called.out
    assert "bench.ripple enters the result 'at', which has a limit: there is no" in called.err


def test_equation_of_two_results_of_one_curve_is_refused(tmp_path):
    """Slope and intercept are correlated by their scatter; only the curve knows the value."""
    several = CURVE.replace(
        "{value: {name: at, at: 4 A, unit: V}}",
        "{value: {name: at, at: 4 A, unit: V}, slope: {name: slope, unit: mΩ}}",
    )[1:] + (
        "  - equation: {result: {name: sum, unit: V}, model: a + s * i,\n"
        "               constants: {i: 1 A}, inputs: {a: at, s: slope}}\n"
    )
    called = check_changed(tmp_path, ("acceptance:", several + "acceptance:"))
    assert called.code == 3
    assert "'at' and 'slope' are results of one analysis" in called.err


FRICTION = """
  - equation:
      result: {name: friction_coefficient, symbol: mu, unit: "1"}
      per: frequency
      model: mu = T / (F * r)
      inputs: {T: torque}
      constants: {F: {value: 1000 N, limits: ±5 N}, r: {value: 10.4 mm, limits: ±0.05 mm}}
"""


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({}, ""),
        ({"* r)": "* F)"}, "the model gives"),
        ({"      per: frequency\n": ""}, "there is a result 'torque' for each frequency"),
    ],
    ids=["fits", "kind", "place"],
)
def test_torque_is_a_result_like_any_other(tmp_path, changed, message):
    """A friction coefficient from the starting torque: its kind and its places are known early."""
    text = find_procedure("starting_torque_1000n").read_text(encoding="utf-8")
    added = FRICTION
    for old, new in changed.items():
        added = added.replace(old, new)
    if "* F)" in added:
        added = added.replace(", r: {value: 10.4 mm, limits: ±0.05 mm}", "")
    (tmp_path / "mu.yaml").write_text(
        text.replace("\nacceptance:", f"{added}\nacceptance:", 1), encoding="utf-8"
    )
    called = call("check", tmp_path / "mu.yaml", "--station", "simulated")
    assert called.code == (3 if message else 0), called.err
    assert message in called.err


def test_failed_analysis_tells_how_to_analyse_the_run_later(tmp_path):
    """Two redundant parameters: the fit finds them only after the measurement."""
    fit = "{expression: {over: [i], model: a + b + 0*i, start: {a: 6 V, b: 6 V}}}"
    text = PROCEDURE.replace(
        "acceptance:", CURVE[1:].replace("{polynomial: {degree: 1}}", fit) + "acceptance:"
    )
    procedure, station = written(tmp_path, procedure=text)
    runs = tmp_path / "runs"
    called = call("run", procedure, "--station", station, "--unattended", "--runs", runs)
    assert called.code == 5, called.err
    (folder,) = runs.iterdir()
    assert "The run was completed, but could not be analysed." in called.err
    assert f"'rigrunner reanalyse {folder} --analysis FILE" in called.err
    other = tmp_path / "other.yaml"
    results = "{name: voltage, unit: V}"
    other.write_text(
        f"rigrunner: analysis/1\nnamed:\n  - readings: {{of: bench.voltage, result: {results}}}\n",
        encoding="utf-8",
    )
    reanalysed = call("reanalyse", folder, "--analysis", other, "--out", tmp_path / "again")
    assert reanalysed.code == 0, reanalysed.err
    assert "voltage,12.01" in (tmp_path / "again/results.csv").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("steps", "refused"),
    [
        ("sweep: {set: bench.current, label: {way: down}, steps: [READ], over: [2 A]}", True),
        ("sweep: {set: bench.current, label: {way: down}, steps: [READ], over: [1 A]}", False),
        ("group: {label: {way: down}, steps: [SCAN [2 A]]}", True),
        ("group: {label: {way: down}, steps: [SCAN [2 A, 1000 mA]]}", False),
    ],
)
def test_hysteresis_needs_a_set_point_that_both_ways_share(tmp_path, steps, refused):
    steps = steps.replace("READ", "measure: {channels: [bench.voltage]}")
    steps = steps.replace("SCAN", "scan: {set: bench.current, channels: [bench.voltage], over:")
    steps = steps.replace("]]}", "]}]}")
    curve = CURVE.replace("{value", HYSTERESIS.replace("dwn", "down") + ", value")[1:]
    called = check_changed(
        tmp_path,
        ("over: [0 A, 1 A, 2 A, 5 A]", "over: [0 A, 1 A, 5 A]"),
        ("analysis:", f"  - {steps}\nanalysis:"),
        ("acceptance:", curve + "acceptance:"),
    )
    assert called.code == (3 if refused else 0), called.err
    if refused:
        at = line_of("results: {hysteresis", tmp_path)
        assert f"supply.yaml:{at}:" in called.err
        assert "bench.current is never the same at way = up and down" in called.err
