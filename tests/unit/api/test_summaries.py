from __future__ import annotations

from dataclasses import replace

from rigrunner.api.data import Measurement
from rigrunner.api.summaries import pairs, table, table_cells


def test_columns_are_aligned_left_and_right():
    text = table(["f", "torque"], [["1 Hz", "0.7"], ["10 Hz", "10.25"]], "lr")
    assert text.splitlines() == [
        "f      torque",
        "-----  ------",
        "1 Hz      0.7",
        "10 Hz   10.25",
    ]


def test_lines_have_no_trailing_blanks():
    text = table(["a", "b"], [["1", ""], ["2", "longer"]])
    assert all(line == line.rstrip() for line in text.splitlines())


def test_table_without_rows_has_only_its_header():
    assert table(["a"], []).splitlines() == ["a", "-"]


def test_pairs_are_aligned():
    assert pairs([("run", "A"), ("verdict", "pass")]) == "run      A\nverdict  pass"


def test_table_has_coordinates_set_points_values_and_readings_with_units():
    units = {"bench.load": "N", "bench.mass": "kg", "dwell": "s", "bench.ratio": "1"}
    written = {"bench.load": "kN", "bench.mass": "g"}
    first = Measurement(
        "weighing", "", {"bench.load": 500.0}, {"bench.mass": 0.0125, "bench.ratio": 2.0}, units,
        coordinates={"phase": "new", "dwell": 60.0}, readings={"bench.state": "V1.2"},
        written_in=written,
    )  # fmt: skip
    second = replace(
        first, setpoints={"bench.load": 1500.0}, values={"bench.mass": 0.007},
        coordinates={"phase": "worn", "dwell": 60.0}, readings={},
    )  # fmt: skip
    assert table_cells([first, second]) == (
        ["phase", "dwell / s", "set bench.load / kN", "bench.mass / g", "bench.ratio / 1",
         "bench.state"],
        [["new", "60", "0.5", "12.5", "2", "V1.2"], ["worn", "60", "1.5", "7.0", "", ""]],
    )  # fmt: skip
