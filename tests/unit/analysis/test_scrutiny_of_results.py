"""The results of an analysis plugin are checked before use."""

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


def checked_findings(*results, missing=(), tables=()):
    """Return the checked findings of an analysis with these results."""
    record = AnalysisRecord(
        name="strange",
        help="-",
        factory=lambda _: lambda _: Findings(results=results, missing=missing, tables=tables),
        yields=lambda _: (OF,),
    )
    registry = Registry((Plugin("analysis", record, Provider("test", "")),))
    return Scrutiny(registry).make("analysis", "strange", {})(SimpleNamespace(recordings=()))


def test_valid_results_are_unchanged():
    assert checked_findings(GOOD, missing=(MISSING,)).results == (GOOD,)


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
def test_invalid_result_is_refused_with_the_plugin_name(result, message):
    with pytest.raises(PluginError, match=message) as caught:
        checked_findings(result)
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
def test_invalid_missing_result_is_refused(missing, message):
    with pytest.raises(PluginError, match=message):
        checked_findings(GOOD, missing=(missing,))


@pytest.mark.parametrize(
    ("row", "message"),
    [((1.0, None), "the table 'T' with None in a cell"), ((1.0,), "rows of {1, 2} columns")],
)
def test_table_with_empty_cells_or_short_rows_is_refused(row, message):
    table = Table(of="drop", title="T", columns=("a", "b"), rows=(("x", 2.0), row))
    with pytest.raises(PluginError, match=message):
        checked_findings(GOOD, tables=(table,))


def test_generator_of_results_is_refused():
    """Checking them would exhaust the generator."""
    with pytest.raises(PluginError, match="gave <generator"):
        checked_findings(GOOD, missing=(missing for missing in [MISSING]))


def test_result_in_an_unknown_unit_is_refused():
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
