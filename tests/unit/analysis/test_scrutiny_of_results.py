"""Results that an analysis gives are looked at before they count."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api import (
    AnalysisRecord,
    Component,
    Estimate,
    Findings,
    MeasurementResult,
    ResultDefinition,
)
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.errors import PluginError
from rigrunner.api.findings import MissingResult, Table
from rigrunner.registry import Registry
from rigrunner.registry.lookup import Plugin, Provider

OF = ResultDefinition(name="drop", unit="mV", per=("load.current",))
LINE = Component("reading", 0.5, 9.0, "normal", common=True, unit="mV")
AT = {"load.current": CoordinateValue(2.0, "A")}
GOOD = MeasurementResult(
    of=OF, estimate=Estimate(12.0, 0.5, 9.0, "mV"), components=(LINE,), coordinates=AT
)
MISSING = MissingResult(of=OF, coordinates={"load.current": CoordinateValue(3.0, "A")}, why="none")


def looked_at(*results, missing=(), tables=()):
    """Return what an analysis gives that has these results."""
    record = AnalysisRecord(
        name="strange",
        help="-",
        factory=lambda _: lambda _: Findings(results=results, missing=missing, tables=tables),
        yields=lambda _: (OF,),
    )
    registry = Registry((Plugin("analysis", record, Provider("test", "")),))
    return Scrutiny(registry).make("analysis", "strange", {})(SimpleNamespace(recordings=()))


def test_what_is_in_order_is_what_it_was():
    assert looked_at(GOOD, missing=(MISSING,)).results == (GOOD,)


@pytest.mark.parametrize(
    ("result", "message"),
    [
        (replace(GOOD, coordinates={}), "'drop' without its coordinate 'load.current'"),
        (replace(GOOD, coordinates={"load.current": 2.0}), "at load.current = 2.0, expected"),
        (
            replace(GOOD, coordinates={"load.current": CoordinateValue(float("nan"), "A")}),
            "expected a CoordinateValue",
        ),
        (replace(GOOD, readings=-5), "'drop' of -5 readings"),
        (replace(GOOD, readings=2.5), "'drop' of 2.5 readings"),
        (replace(GOOD, components=(replace(LINE, dof=-3.0),)), "-3.0 degrees of freedom"),
        (replace(GOOD, components=(replace(LINE, u=-0.5),)), "a budget line 'reading' with u = -0"),
        (replace(GOOD, components=(replace(LINE, u=0.4),)), "with u = 0.5, by its budget 0.4"),
    ],
)
def test_a_result_that_cannot_be_used_names_its_plugin(result, message):
    with pytest.raises(PluginError, match=message) as caught:
        looked_at(result)
    assert caught.value.message.startswith("the analysis 'strange' gave ")


@pytest.mark.parametrize(
    ("missing", "message"),
    [
        (replace(MISSING, coordinates={"x": CoordinateValue("q")}), "without its coordinate"),
        (replace(MISSING, coordinates={"load.current": 3.0}), "expected a CoordinateValue"),
        (replace(MISSING, why=None), "None as the reason"),
        (replace(MISSING, coordinates=AT), "two results of one name and place"),
    ],
)
def test_so_does_a_missing_one(missing, message):
    with pytest.raises(PluginError, match=message):
        looked_at(GOOD, missing=(missing,))


@pytest.mark.parametrize(
    ("row", "message"),
    [((1.0, None), "the table 'T' with None in a cell"), ((1.0,), "rows of {1, 2} columns")],
)
def test_a_table_has_texts_and_numbers_in_all_its_cells(row, message):
    table = Table(of="drop", title="T", columns=("a", "b"), rows=(("x", 2.0), row))
    with pytest.raises(PluginError, match=message):
        looked_at(GOOD, tables=(table,))


def test_results_that_can_be_looked_at_only_once_are_refused():
    """Who looks at them would leave none."""
    with pytest.raises(PluginError, match="gave <generator"):
        looked_at(GOOD, missing=(missing for missing in [MISSING]))


def test_a_result_in_no_unit_is_refused_with_its_name():
    record = AnalysisRecord(
        name="strange",
        help="-",
        factory=lambda _: None,
        yields=lambda _: (replace(OF, unit="<b>"),),
    )
    registry = Registry((Plugin("analysis", record, Provider("test", "")),))
    message = "the analysis 'strange' yields 'drop' in an unknown unit '<b>'"
    with pytest.raises(PluginError, match=message):
        registry.definitions("strange", {})
