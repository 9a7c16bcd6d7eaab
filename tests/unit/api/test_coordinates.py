"""Label values as written, stored and shown, and selection by them."""

from __future__ import annotations

import pytest

from rigrunner.api.coordinates import (
    coordinate_text,
    coordinates_text,
    in_si,
    labels_of,
    matches,
    mixed_labels,
)
from rigrunner.api.steps import StepSettings


def label(value, name="x"):
    return StepSettings.model_validate({"label": {name: value}}).label[name]


@pytest.mark.parametrize(
    ("written", "stored", "unit"),
    [
        ("wear", "wear", ""),
        ("60 s", 60.0, "s"),
        ("2 min", 120.0, "s"),
        ("-5 °C", 268.15, "K"),
        (True, True, ""),
        (2, 2.0, ""),
        (0.5, 0.5, ""),
        ("4711-B", "4711-B", ""),
        ("2026-11-23", "2026-11-23", ""),
        ("3rd", "3rd", ""),
        ("yes", "yes", ""),
    ],
)
def test_label_value_is_stored_with_its_type(written, stored, unit):
    value, symbol = in_si(label(written))
    assert (value, symbol) == (pytest.approx(stored) if isinstance(stored, float) else stored, unit)
    assert type(value) is type(stored)


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("1,5 N", "decimal comma"),
        ("1,5N", "decimal comma"),
        ("60 seconds", "unknown unit 'seconds'"),
        ("", "expected a text, a number, true or false, or a quantity"),
        (None, "got nothing, expected"),
        ([1], "expected a text"),
        ("x" * 81, "a text of 81 characters, expected at most 80"),
        ("a\x07b", "control characters"),
    ],
)
def test_ambiguous_label_value_is_refused(written, message):
    with pytest.raises(ValueError, match=message):
        label(written)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("tester.load", "'tester.load' names a set-point"),
        ("2nd", "is not a name"),
        ("elapsed", "tables have a column 'elapsed' already"),
        ("utc", "tables have a column 'utc' already"),
    ],
)
def test_reserved_or_invalid_label_name_is_refused(name, message):
    with pytest.raises(ValueError, match=message):
        label("a", name)


def test_coordinates_in_words():
    assert [coordinate_text(value) for value in (3, 2.0, True, False, "wear")] == [
        "3", "2", "yes", "no", "wear",
    ]  # fmt: skip
    coordinates = {"phase": "wear", "dwell": 60.0, "block": 3}
    assert coordinates_text(coordinates, {"dwell": "s"}) == "phase wear, dwell 60 s, block 3"
    labels = {"phase": "wear", "dwell": 60.0, "aged": False}
    assert labels_of({**labels, "block": 3}) == labels


def test_selection_compares_converted_values():
    coordinates = {"phase": "wear", "dwell": 60.0, "aged": True, "block": 1}
    settings = StepSettings.model_validate
    for where in ({"phase": "wear"}, {"dwell": "1 min"}, {"aged": True}, {"block": 1}, {}):
        assert matches(coordinates, settings({"label": where}).label), where
    for where in ({"phase": "final"}, {"dwell": "59 s"}, {"aged": 1}, {"block": True}, {"y": 1}):
        assert not matches(coordinates, settings({"label": where}).label), where


def test_items_at_one_set_point_may_differ_by_counter_but_not_by_label():
    wear, final = {"phase": "wear", "block": 1}, {"phase": "final"}
    at_10, at_20 = {"t.frequency": 10.0}, {"t.frequency": 20.0}
    assert not mixed_labels([(at_10, wear, {}), (at_10, {**wear, "block": 2}, {})])
    assert not mixed_labels([(at_10, wear, {}), (at_20, final, {})])
    assert mixed_labels([(at_10, wear, {}), (at_10, final, {})]) == "phase wear; phase final"
    assert mixed_labels([(at_10, {}, {}), (at_10, final, {})]) == "no label; phase final"
