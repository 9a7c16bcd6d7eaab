"""Units that plugins add: valid ones, clashes, and those that are stored with a run."""

from __future__ import annotations

from dataclasses import replace

import pytest
from pydantic import ValidationError

from rigrunner.api.errors import DataError
from rigrunner.api.instruments import Instrument
from rigrunner.api.quantity import parse_quantity, quantity_pattern
from rigrunner.api.unit_tables import UnitDefinition
from rigrunner.api.units import (
    QuantityError,
    define,
    find_unit,
    kinds,
    rate_of,
    si_symbol,
    units_of,
)
from rigrunner.runfile.added_units import define_units_of, unit_texts

HORSEPOWER = UnitDefinition("tstHp", "power", "kg·m²/s³", 745.6998715822702, spellings=("tstHP",))
GRADE = UnitDefinition("tstG", "test grade", "1")
HALF = UnitDefinition("tstH", "test grade", "1", 0.5)
DELISLE = UnitDefinition("tstDe", "temperature", "K", 2 / 3, 100.0)
LOUD = UnitDefinition("tstdB", "test level", "1", logarithmic=True)


def read(text):
    quantity = parse_quantity(text)
    return str(quantity), quantity.si, quantity.dimension


def test_added_unit_is_read_in_all_spellings_and_products():
    define([HORSEPOWER], "one")
    assert read("2 tstHP") == ("2 tstHp", 2 * 745.6998715822702, "power")
    assert read("2 tstHp/m2") == ("2 tstHp/m²", pytest.approx(2 * 745.6998715822702), "W/m²")
    assert read("3 tstHp·s")[2] == "energy"
    with pytest.raises(QuantityError, match="is a power, not a torque"):
        parse_quantity("2 tstHp", "torque")


def test_added_unit_may_have_an_offset():
    define([DELISLE], "one")
    assert read("3 tstDe") == ("3 tstDe", 102.0, "temperature")
    with pytest.raises(QuantityError, match="which has an offset zero"):
        parse_quantity("3 tstDe/s")


def test_new_kind_differs_from_others_of_the_same_dimension():
    define([HALF, GRADE], "one")
    assert read("4 tstH") == ("4 tstH", 2.0, "test grade")
    assert si_symbol("test grade") == "tstG"
    assert set(units_of("test grade")) == {"tstG", "tstH"}
    assert "test grade" in kinds()
    with pytest.raises(QuantityError, match="is a test grade, not a ratio"):
        parse_quantity("4 tstH", "ratio")


def test_logarithmic_unit_is_refused_in_products():
    define([LOUD], "one")
    assert rate_of("test level") is None
    with pytest.raises(QuantityError, match="no unit is made of tstdB"):
        parse_quantity("1 tstdB/s")


def test_quantity_pattern_has_added_units():
    define([UnitDefinition("tstEd", "mass", "kg", 2.0)], "one")
    assert "tstEd" in quantity_pattern("mass")
    assert "tstEd" not in quantity_pattern("time")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"symbol": "N"}, "and Rigrunner itself has 'N'"),
        ({"spellings": ("bar",)}, "and Rigrunner itself has 'bar'"),
        ({"symbol": "m2"}, "which reads as a power of a unit"),
        ({"symbol": "a b"}, "expected letters"),
        ({"symbol": ""}, "expected letters"),
        ({"base": "kg"}, r"has base 'kg'; a power is in kg·m²/s³"),
        ({"base": "N·m"}, "expected 1, or products of kg, m, s"),
        ({"base": "m²/"}, "expected 1, or products of kg, m, s"),
        ({"factor": 0.0}, "expected more than 0"),
        ({"factor": float("nan")}, "expected more than 0"),
        ({"offset": float("inf")}, "has offset inf"),
        ({"kind": "Power!"}, "expected words of small letters"),
        ({"kind": "no such kind"}, "of which no unit has factor 1 and offset 0"),
        ({"kind": "level"}, "a level is in 1, logarithmic"),
    ],
)
def test_invalid_unit_definition_is_refused(changes, message):
    with pytest.raises(QuantityError, match=message):
        define([replace(HORSEPOWER, symbol=changes.pop("symbol", "tstNo"), **changes)], "one")


def test_refused_unit_rejects_all_units_of_the_plugin():
    with pytest.raises(QuantityError):
        define([UnitDefinition("tstFirst", "mass", "kg"), replace(HORSEPOWER, symbol="N")], "one")
    with pytest.raises(QuantityError, match="unknown unit"):
        parse_quantity("1 tstFirst")


def test_conflicting_definitions_of_a_unit_name_both_plugins():
    clashing = UnitDefinition("tstC", "mass", "kg", 2.0)
    define([clashing], "plugin_one")
    define([clashing], "plugin_two")
    assert read("1 tstC")[1] == 2.0
    define([replace(clashing, factor=3.0)], "plugin_three")
    for text in ("1 tstC", "1 tstC/s"):
        with pytest.raises(QuantityError, match=r"by plugin_one .* and plugin_three .*3\.0 in kg"):
            parse_quantity(text)
        assert find_unit(text.split()[1]) is None


def test_find_unit_returns_none_for_unknown_units():
    define([HORSEPOWER], "one")
    assert find_unit(" tstHP ").symbol == "tstHp"
    assert find_unit("N·m").dimension == "torque"
    assert [find_unit(symbol) for symbol in ("", "tstNone", "N·tstNone")] == [None, None, None]


def test_conflicting_definitions_of_a_kind_name_both_plugins():
    define([UnitDefinition("tstA", "test clash", "1")], "plugin_one")
    define([UnitDefinition("tstB", "test clash", "1")], "plugin_two")
    with pytest.raises(QuantityError, match=r"by plugin_one .* and plugin_two"):
        parse_quantity("1 tstA")


def test_later_definition_of_a_plugin_replaces_the_former():
    define([UnitDefinition("tstAgain", "mass", "kg", 2.0)], "one")
    define([UnitDefinition("tstAgain", "mass", "kg", 3.0)], "one")
    assert read("1 tstAgain")[1] == 3.0


def test_stored_units_of_a_run_are_defined_on_reading():
    definitions = [
        replace(HORSEPOWER, symbol="tstK", spellings=("tstKk",)),
        replace(DELISLE, symbol="tstKd"),
        replace(LOUD, symbol="tstKl", kind="kept level"),
    ]
    define_units_of(unit_texts(definitions) | {"Rigrunner": "1.0"}, "run-1")
    assert read("2 tstKk") == ("2 tstK", 2 * 745.6998715822702, "power")
    assert read("3 tstKd") == ("3 tstKd", 102.0, "temperature")
    assert rate_of("kept level") is None


def test_damaged_unit_of_a_run_is_a_data_error():
    with pytest.raises(DataError, match="run-2: the unit tstX is damaged"):
        define_units_of({"unit tstX": "power; 1"}, "run-2")
    with pytest.raises(DataError, match="run-2"):
        define_units_of({"unit tstX": "power; kg; 1.0; 0.0; linear; tstX"}, "run-2")


def test_register_accepts_an_instrument_of_a_new_kind():
    define([GRADE, HALF], "one")
    entry = {"channel": "tester.grade", "measures": "test grade", "serial": "G-1"}
    instrument = Instrument.model_validate(entry | {"accuracy": "3 tstH"})
    assert instrument.limit_of_error(10.0) == 1.5
    with pytest.raises(ValidationError, match="'test grad' is not a quantity"):
        Instrument.model_validate(entry | {"measures": "test grad"})
