"""`rigrunner check` on a model in a procedure: line and column, within a second."""

from __future__ import annotations

import time

import pytest

from helpers_any_quantity import STATION, written
from helpers_cli import call

PROCEDURE = """\
rigrunner: procedure/2
id: PSU-EQ
revision: "A"
title: Noise of a power supply
inputs: {specimen: {ask: Serial number, unattended: PSU-1}}
uses: {bench: supply_bench}
main:
  - sweep:
      set: bench.current
      over: [1 A, 2 A]
      steps: [{measure: {channels: [bench.voltage, bench.ripple]}}]
analysis:
  - equation:
      result: {name: noise, symbol: n, unit: "%"}
      per: bench.current
      inputs: {U: bench.voltage, r: bench.ripple}
      model: MODEL
"""
AT = 17, 14
"""Line and column where MODEL begins."""


def checked(folder, model):
    procedure, station = written(folder, procedure=PROCEDURE.replace("MODEL", model))
    began = time.perf_counter()
    called = call("check", procedure, "--station", station)
    return called, time.perf_counter() - began


def test_valid_model_passes(tmp_path):
    called, _ = checked(tmp_path, "n = r / U")
    assert called.code == 0, called.err
    station = tmp_path / "station.yaml"
    assert station.read_text(encoding="utf-8") == STATION


@pytest.mark.parametrize(
    ("model", "line", "column", "message"),
    [
        ("n = r / U + U", 17, 26, "'U', a voltage, is added to 'r / U', a number"),
        ("r / W", 17, 18, "'W' is not known"),
        ("r.real / U", 17, 15, "FULL STOP"),
        ('"r / U ** 9 ** 9 ** 9"', 17, 29, "is a power of numbers within a power"),
        (
            "|\n        n = r / U\n          + exp(U)",
            19,
            17,
            "'U' is a voltage; exp takes a number",
        ),
        (f"{'+'.join(['r'] * 10**5)}", 17, 2014, "the model has 199999 characters"),
        (f"{'(' * 700}r{')' * 700}", 17, 14, "nested too deeply"),
        ("r / \u0405", 17, 18, "CYRILLIC CAPITAL LETTER DZE"),
        ("__import__('os')", 17, 14, "LOW LINE"),
    ],
    ids=range(9),
)
def test_invalid_model_is_refused_with_its_column(tmp_path, model, line, column, message):
    called, seconds = checked(tmp_path, model)
    assert called.code == 3
    assert f"supply.yaml:{line}:{column}: error: analysis[0].equation.model: " in called.err
    assert message in called.err
    assert seconds < 10  # one second on an idle machine


@pytest.mark.parametrize(
    ("more", "at", "message"),
    [
        ("constants: {f: 2 1}", "18:22", "constants.f: the model does not use 'f'"),
        ("constants: {U: 2 1}", "18:22", "constants.U: 'U' is an input and a constant"),
        (
            (
                "correlations:\n        - {between: [U, r], r: 0.1}\n"
                "        - {between: [U, q], r: 0.1}"
            ),
            "20:21",
            "correlations[1].between: there is no 'q'",
        ),
    ],
    ids=["unused", "twice", "unknown"],
)
def test_inconsistent_keys_are_refused_with_their_place(tmp_path, more, at, message):
    called, _ = checked(tmp_path, f"r / U\n      {more}")
    assert called.code == 3
    assert f"supply.yaml:{at}: error: analysis[0].equation.{message}" in called.err


def test_unmeasured_and_unregistered_channels_are_refused(tmp_path):
    procedure = PROCEDURE.replace("MODEL", "r / U")
    wrong = procedure.replace("bench.ripple}", "bench.rippel}")
    called = call("check", *_with_station(tmp_path, wrong))
    assert "bench.rippel is not measured or set in any step" in called.err
    limited = procedure + (
        "acceptance: {rule: simple, limits: [{of: noise, worst: yes, max: 1 %, source: a}]}\n"
    )
    called = call("check", *_with_station(tmp_path, limited))
    assert "bench.ripple enters the result 'noise', which has a limit" in called.err


def test_limit_of_a_refused_analysis_is_not_reported(tmp_path):
    limited = PROCEDURE.replace("MODEL", "r / U").replace("bench.ripple}", "of.bench.ripple}") + (
        "acceptance: {rule: simple, limits: [{of: noise, worst: yes, max: 1 %, source: a}]}\n"
    )
    called = call("check", *_with_station(tmp_path, limited))
    assert "'of.bench.ripple' is not of the form role.name" in called.err
    assert "there is no result" not in called.err


def _with_station(folder, procedure):
    file, station = written(folder, procedure=procedure)
    return file, "--station", station
