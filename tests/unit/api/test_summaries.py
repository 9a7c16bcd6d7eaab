from __future__ import annotations

from rigrunner.api.summaries import pairs, table


def test_columns_are_aligned_and_numbers_end_together():
    text = table(["f", "torque"], [["1 Hz", "0.7"], ["10 Hz", "10.25"]], "lr")
    assert text.splitlines() == [
        "f      torque",
        "-----  ------",
        "1 Hz      0.7",
        "10 Hz   10.25",
    ]


def test_no_line_ends_in_blanks():
    text = table(["a", "b"], [["1", ""], ["2", "longer"]])
    assert all(line == line.rstrip() for line in text.splitlines())


def test_a_table_without_rows_is_its_header():
    assert table(["a"], []).splitlines() == ["a", "-"]


def test_pairs_are_aligned():
    assert pairs([("run", "A"), ("verdict", "pass")]) == "run      A\nverdict  pass"
