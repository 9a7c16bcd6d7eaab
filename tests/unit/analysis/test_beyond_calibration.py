"""Readings beyond the calibrated range: in the result's notes, and in a certificate."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rigrunner.analysis.analyse import analyse
from rigrunner.api.data import Measurement
from rigrunner.api.instruments import Instrument
from rigrunner.api.limits import ValueLimit
from rigrunner.certificate.validity import not_calibrated
from rigrunner.procedure import AnalysisRef
from rigrunner.registry import load_registry
from unit.analysis.helpers_runs import run_of

VOLTAGE = AnalysisRef.model_validate(
    {"readings": {"of": "meter.voltage", "result": {"name": "mean", "unit": "V"}}}
)


def entry(channel="meter.voltage", measures="voltage", least=None, most="10 V", **more):
    limits = {"max": most} | ({} if least is None else {"min": least})
    return Instrument.model_validate(
        {"channel": channel, "measures": measures, "serial": "M-1", "accuracy": "10 mV",
         "range": limits} | more
    )  # fmt: skip


def analysed(instrument, *values, analyses=(VOLTAGE,), zeros=None, limited=False, unit="V"):
    of = instrument.channel
    limits = (ValueLimit(of, -1e3, 1e3, unit),) if limited else ()
    rows = tuple(
        Measurement("t", "2026-01-05T10:00:00Z", {}, {of: value}, {of: unit}, limits=limits,
                    zeros=zeros or {})
        for value in values
    )  # fmt: skip
    run = replace(run_of(), measurements=rows, instruments={of: instrument}, zeros=zeros or {})
    return analyse(run, analyses, acceptance=None, measurand=None, lookup=load_registry())


def test_they_are_a_note_of_the_result_and_of_a_certificate():
    found = analysed(entry(), 5.0, 10.5)
    assert found.notes[-1] == (
        "meter.voltage exceeded its calibrated range: 10.5 V was recorded, the calibration holds up"
        " to 10 V (105 %)."
    )
    assert [(each.kind, each.where) for each in not_calibrated(found)] == [
        ("range", "meter.voltage")
    ]
    assert not analysed(entry(), 5.0, 9.9).beyond


def test_values_that_only_have_limits_are_held_to_it_too():
    found = analysed(entry(), 10.5, analyses=(), limited=True)
    assert [each.where for each in not_calibrated(found)] == ["meter.voltage"]


@pytest.mark.parametrize(("value", "is_beyond"), [(-0.009, False), (-0.02, True)])
def test_noise_about_zero_is_within_a_range_that_begins_there(value, is_beyond):
    found = analysed(entry(least="0 V"), value, 5.0)
    assert bool(found.beyond) == is_beyond
    if is_beyond:
        assert found.beyond["meter.voltage"].endswith("the calibration holds from 0 V")


def test_a_force_counts_less_its_zero():
    told = {"of": "cell.force", "result": {"name": "force", "unit": "N"}}
    force = {"analyses": (AnalysisRef.model_validate({"readings": told}),), "unit": "N"}
    cell = entry("cell.force", "force", most="100 N", accuracy="1 N")
    assert not analysed(cell, 104.0, zeros={"cell.force": 5.0}, **force).beyond
    assert analysed(cell, 98.0, zeros={"cell.force": -5.0}, **force).beyond
