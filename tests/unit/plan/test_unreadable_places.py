"""A set-point at which a device cannot be read is reported by `check`, with its line."""

from __future__ import annotations

import pytest

PROCEDURE = """\
rigrunner: procedure/2
id: PLACES
revision: "A"
title: A table
uses: {bench: table}
main:
  - STEPS
"""
SWEEP = """sweep:
      set: bench.temperature
      over: [0 °C, 50 °C, 100 °C, 60 °C]
      steps: [{measure: {channels: [bench.resistance]}}]"""
SCAN = "scan: {set: bench.temperature, over: [0 °C, 50 °C, 100 °C], channels: [bench.resistance]}"


@pytest.mark.parametrize("steps", [SWEEP, SCAN])
def test_set_point_without_a_row_is_refused(checked, steps):
    done = checked(PROCEDURE.replace("STEPS", steps))
    assert done.code == 3
    assert "bench cannot be read here: the table has no row for temperature" in done.err
    assert "it has rows for temperature 0 °C; temperature 100 °C" in done.err
    assert "p.yaml:7" in done.err or "p.yaml:10" in done.err


@pytest.mark.parametrize(
    "steps",
    [
        SWEEP.replace(", 50 °C", "").replace(", 60 °C", ""),
        SCAN.replace(", 50 °C", ""),
        "set: {bench.temperature: 50 °C}",
    ],
)
def test_set_points_with_rows_are_accepted(checked, steps):
    done = checked(PROCEDURE.replace("STEPS", steps))
    assert done.code == 0, done.err


def test_set_point_out_of_range_is_one_problem_in_the_unit_it_is_written_in(checked):
    done = checked(PROCEDURE.replace("STEPS", SWEEP.replace("50 °C, 100 °C, 60", "110")))
    assert done.err.count("error:") == 1
    assert "110 °C is out of range (0 to 100 °C)" in done.err


def test_table_starts_at_its_lowest_temperature(checked):
    done = checked(PROCEDURE.replace("STEPS", "measure: {channels: [bench.resistance]}"))
    assert done.code == 0, done.err
