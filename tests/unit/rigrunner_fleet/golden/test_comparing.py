"""A result compared with its reference."""

from __future__ import annotations

from math import inf

import pytest

from rigrunner_fleet.golden.comparing import Move, Standing, by_severity, compare, not_compared
from rigrunner_fleet.golden.figures import AtFrequency, Figure, verdicts
from rigrunner_fleet.golden.overall import Overall
from rigrunner_fleet.golden.reference import Snapshot
from rigrunner_fleet.golden.words import details


def snapshot(torque=0.7, expanded=0.02, **other):
    values = {
        "sha256": repr((torque, expanded, other)),
        "method": "energy",
        "verdicts": {"run": "pass"},
        "checks": {"cycles": True, "energy: steady": True},
        "sources": ("energy",),
        "figures": {
            "result": Figure(torque, expanded, "N·m"),
            "result at 5 Hz": Figure(torque, expanded, "N·m"),
            "energy: torque at 5 Hz": Figure(torque, expanded, "N·m"),
        },
        "frequencies": (AtFrequency(5.0, "result at 5 Hz"),),
    }
    return Snapshot(**{**values, **other})


def without_result(**other):
    return snapshot(**{"figures": {}, "verdicts": {}, "frequencies": (), **other})


REFUSED = Snapshot(problem="no no-load recording")


@pytest.mark.parametrize(
    ("before", "after", "standing"),
    [
        (snapshot(), snapshot(), Standing.EQUAL),
        (snapshot(), snapshot(sha256="another"), Standing.OTHER),
        (snapshot(), snapshot(0.7 + 1e-9), Standing.WITHIN),
        (snapshot(), snapshot(0.701), Standing.BEYOND),
        (snapshot(), snapshot(expanded=0.021), Standing.BEYOND),
        (snapshot(), snapshot(expanded=None), Standing.BEYOND),
        (snapshot(expanded=None), snapshot(0.700001, expanded=None), Standing.BEYOND),
        (snapshot(), snapshot(checks={"cycles": False, "energy: steady": True}), Standing.CHECKS),
        (snapshot(), snapshot(verdicts={"run": "fail"}), Standing.VERDICT),
        (snapshot(), snapshot(verdicts={"run": "pass", "35 Hz": "fail"}), Standing.VERDICT),
        (snapshot(), REFUSED, Standing.REFUSED),
        (snapshot(), without_result(), Standing.REFUSED),
        (REFUSED, snapshot(), Standing.ACCEPTED),
        (without_result(), snapshot(), Standing.ACCEPTED),
        (REFUSED, REFUSED, Standing.EQUAL),
        (REFUSED, Snapshot(problem="in other words"), Standing.OTHER),
    ],
)
def test_standing_of_each_difference(before, after, standing):
    assert compare("run", before, after).standing is standing


def test_tolerance_is_a_share_of_the_reference_uncertainty():
    moved = snapshot(0.7019)  # 0.095 U
    assert compare("run", snapshot(), moved, 0.1).standing is Standing.WITHIN
    assert compare("run", snapshot(), moved, 0.09).standing is Standing.BEYOND


def test_shift_is_in_units_of_the_reference_uncertainty():
    (result, at_5) = compare("run", snapshot(), snapshot(0.71, 0.03)).moves
    assert (result.name, at_5.name) == ("result", "result at 5 Hz")
    assert result.in_u == pytest.approx(0.5)
    assert result.of_u == pytest.approx(0.5)


def test_other_unit_is_an_infinite_shift():
    before, after = Figure(1.0, 0.1, "N·m"), Figure(1.0, 0.1, "mN·m")
    assert Move(name="x", before=before, after=after).size == inf


def test_added_method_is_no_shift_but_missing_figures_are():
    more = snapshot(
        sources=("energy", "other"),
        figures={**snapshot().figures, "other: torque at 5 Hz": Figure(1.0, 0.1, "N·m")},
        checks={**snapshot().checks, "other: can be applied": True},
    )
    assert compare("run", snapshot(), more).standing is Standing.OTHER
    gone = {**snapshot().figures}
    del gone["energy: torque at 5 Hz"], gone["result at 5 Hz"]
    assert compare("run", snapshot(), snapshot(figures=gone)).standing is Standing.BEYOND


def test_each_visit_of_a_frequency_has_a_verdict():
    def verdicts_of(*parts):
        limits = [{"of": "5 Hz", "verdict": verdict} for verdict in parts]
        return verdicts({"decision": {"verdict": "fail", "parts": limits}})

    assert verdicts_of("pass", "fail") == {"run": "fail", "5 Hz": "pass", "5 Hz (2)": "fail"}
    before, after = (snapshot(verdicts=verdicts_of(first, "fail")) for first in ("pass", "fail"))
    assert compare("run", before, after).standing is Standing.VERDICT


def test_most_severe_comparisons_come_first():
    runs = [
        compare("equal", snapshot(), snapshot()),
        compare("small", snapshot(), snapshot(0.71)),
        compare("large", snapshot(), snapshot(0.72)),
        compare("flipped", snapshot(), snapshot(verdicts={"run": "fail"})),
        not_compared("gone", snapshot(), REFUSED, "there is no gone"),
    ]
    ordered = [run.name for run in sorted(runs, key=by_severity)]
    assert ordered == ["gone", "flipped", "large", "small", "equal"]


def overall(*runs):
    return Overall(runs=runs, tolerance=1e-6, made_by=())


def test_overall_statistics_of_all_runs():
    moved = overall(
        compare("a", snapshot(), snapshot(0.71)),
        compare("b", snapshot(), snapshot(0.69)),
        compare("c", snapshot(), snapshot(0.74)),
        compare("d", snapshot(), snapshot(verdicts={"run": "fail"})),
    )
    # shifts of 0.5, -0.5, 2 and 0 U: mean 0.5, sum of squares about it 0 + 1 + 2.25 + 0.25
    spread = moved.shifts()
    assert (spread.n, spread.largest) == (4, pytest.approx(2.0))
    assert spread.mean == pytest.approx(0.5)
    assert spread.deviation == pytest.approx((3.5 / 3) ** 0.5)
    (at_5,) = moved.by_frequency()
    assert at_5.frequency_hz == 5
    assert at_5.shift_nm.mean == pytest.approx(0.01)
    assert moved.verdict_flips() == {("pass", "fail"): 1}
    assert moved.exit_code == 1
    assert overall(compare("a", snapshot(), snapshot())).exit_code == 0
    assert overall(not_compared("a", snapshot(), REFUSED, "gone")).exit_code == 5


def test_details_of_a_run_as_text():
    comparison = compare("run", snapshot(), snapshot(0.71, verdicts={"run": "fail"}))
    assert list(details(comparison)) == [
        "verdict: pass -> fail",
        "result: 0.70000 -> 0.71000 N·m (+0.50 U)",
        "result at 5 Hz: 0.70000 -> 0.71000 N·m (+0.50 U)",
    ]
