"""Friction of the support under load: measured with a known bearing, then used."""

from __future__ import annotations

import json

import pytest
import yaml

from helpers_cli import call
from helpers_workflow import START, quick_procedure, run, station_file
from rigrunner.clock import SimulatedClock
from rigrunner.runfile import read
from rigrunner_bearings.known_bearing import KNOWN_FRICTION

GROWTH = 0.018
"""Growth of the simulated support's friction of 0.7597 N·m, at 1000 N."""
KNOWN_NM = 0.012
TRUE_NM = 0.7262
"""The simulated bearing's starting torque under 1000 N."""
SEED = "{seed: 1}"
SUPPORT = f"seed: 1, support: {{growth_per_kilonewton: {100 * GROWTH:g} %}}"
KNOWN = (
    f"{{{SUPPORT}, bearing: {{starting_torque: {KNOWN_NM} N·m, kinetic_torque: {KNOWN_NM} N·m}}}}"
)
INERTIA = "  inertia: 0.00233 kg·m²"


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A run with the known bearing, whose data sheet is slightly wrong, as its limit allows."""
    folder = tmp_path_factory.mktemp("support")
    clock, runs = SimulatedClock(START), folder / "runs"
    done = run(
        quick_procedure(folder, "support_friction"),
        runs,
        station=station_file(folder, (SEED, KNOWN)),
        clock=clock,
        given={"known_friction": "11 mN·m", "known_limit": "2 mN·m", "specimen": "K-7"},
    )
    return folder, clock, done.folder


@pytest.mark.thorough
def test_measured_growth_covers_the_true_growth(lab):
    _, _, measured = lab
    called = call("support-friction", measured, "--json")
    assert called.code == 0, called.err
    growth = json.loads(called.out)
    assert abs(growth["growth"] - GROWTH) < growth["growth_expanded"] < 0.012
    assert growth["load_n"] == pytest.approx(1000, rel=0.01)
    assert "K-7" in growth["source"]
    assert read(measured).header.run_id[:15] in growth["source"]


@pytest.mark.thorough
@pytest.mark.thorough
def test_starting_torque_uses_the_measured_growth(lab):
    """The printed lines are put into the station unchanged."""
    folder, clock, measured = lab
    called = call("support-friction", measured)
    entry = called.out[called.out.index("rig:") :].partition("\n")[2].rstrip()
    assert yaml.safe_load(entry)["support_under_load"]["source"]
    run(quick_procedure(folder, "no_load_inertia_sweep"), folder / "runs", clock=clock)
    assumed, measured = (_starting_torque(folder, clock, lines) for lines in ("", f"{entry}\n"))
    assert _support(assumed) == "support friction under load (assumed, not measured)"
    assert "K-7" in _support(measured)
    torque, expanded = _mean(measured)
    assert abs(torque - TRUE_NM) < expanded < _mean(assumed)[1]


def _starting_torque(folder, clock, lines):
    """Return the result of the shipped procedure on the rig, with more lines in its station."""
    station = station_file(folder, (SEED, f"{{{SUPPORT}}}"), (INERTIA, f"{lines}{INERTIA}"))
    clock.sleep(600)
    procedure = quick_procedure(folder, "starting_torque_1000n")
    done = run(procedure, folder / "runs", station=station, clock=clock)
    return json.loads((done.folder / "result.json").read_text(encoding="utf-8"))


def _support(found):
    (line,) = (
        component["name"]
        for component in found["headline"]["budget"]
        if component["name"].startswith("support friction")
    )
    return line


def _mean(found):
    mean = found["headline"]["compensated"]
    return mean["value"], mean["expanded_uncertainty_95"]


@pytest.mark.thorough
def test_bearing_with_too_much_friction_is_refused(tmp_path):
    done = run(
        quick_procedure(tmp_path, "support_friction"),
        tmp_path / "runs",
        station=station_file(tmp_path, (SEED, KNOWN)),
        given={KNOWN_FRICTION: "0.4 N·m"},
    )
    called = call("support-friction", done.folder)
    assert called.code == 5
    assert "at most 25 % is possible" in called.err


def test_run_of_another_procedure_is_refused(tmp_path):
    done = run(quick_procedure(tmp_path, "no_load_inertia_sweep"), tmp_path / "runs")
    called = call("support-friction", done.folder)
    assert called.code == 5
    assert "has no input 'known_friction'" in called.err
