"""Limits that do not match their results are refused by `check`, with their line."""

from __future__ import annotations

import pytest

PROCEDURE = """\
rigrunner: procedure/2
id: PLACES
revision: "A"
title: Limits over a temperature
uses: {bench: table}
main:
  - sweep:
      set: bench.temperature
      over: [0 °C, 100 °C]
      steps: [{measure: {channels: [bench.resistance]}}]
analysis:
  - readings: {of: bench.resistance, per: bench.temperature, result: {name: R, unit: Ω}}
acceptance:
  limits:
    - of: R
      LIMIT
      source: a drawing
"""
LINE = (
    "max: {base: 101 Ω, rise: 0.4 Ω, per: 1 K, over: bench.temperature}\n"
    "      each: bench.temperature"
)
TABLE = (
    "min: {over: bench.temperature, points: [[0 °C, 99 Ω], [100 °C, 138 Ω]]}\n"
    "      each: bench.temperature"
)


@pytest.mark.parametrize("limit", [LINE, TABLE, "{where}: {at}\n      max: 101 Ω".format(
    where="where", at="{bench.temperature: 32 °F}")])  # fmt: skip
def test_matching_limit_is_accepted(checked, limit):
    done = checked(PROCEDURE.replace("LIMIT", limit))
    assert done.code == 0, done.err


@pytest.mark.parametrize(
    ("limit", "place", "words"),
    [
        (LINE.replace("per: 1 K", "per: 1 A"), "p.yaml:16:44",
         "max.per: got '1 A', a current; bench.temperature is a temperature"),
        (TABLE.replace("0 °C,", "0 V,").replace("100 °C", "9 V"), "p.yaml:16:48",
         "min.points[0][0]: got '0 V', a voltage; bench.temperature is a temperature"),
        (TABLE.replace("[100 °C", "[80 °C"), "p.yaml:16:12",
         "min: the limit is known from 0 °C to 80 °C, not at 100 °C"),
        ("where: {bench.temperature: 70 N}\n      max: 101 Ω", "p.yaml:16:34",
         "where.bench.temperature: got '70 N', a force; bench.temperature is a temperature"),
        ("where: {bench.temperature: 70 °F}\n      max: 101 Ω", "p.yaml:16:34",
         "where.bench.temperature: R is not measured at 70 °F"),
        (LINE + "\n      min: 120 Ω", "p.yaml:16:12", "the lower limit, 120 Ω, is not below the"),
    ],
)  # fmt: skip
def test_limit_that_does_not_match_its_result_is_refused(checked, limit, place, words):
    done = checked(PROCEDURE.replace("LIMIT", limit))
    assert done.code == 3
    assert words in done.err
    assert place in done.err


def test_limit_at_a_place_that_its_result_does_not_have_is_one_problem(checked):
    """Whether 70 N can be a temperature does not matter then."""
    limit = "where: {bench.temperature: 70 N}\n      max: 101 Ω"
    text = PROCEDURE.replace("per: bench.temperature, ", "").replace("LIMIT", limit)
    done = checked(text)
    assert "'R' has no coordinate 'bench.temperature'" in done.err
    assert done.err.count("p.yaml:") == 1
