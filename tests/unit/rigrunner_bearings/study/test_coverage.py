from __future__ import annotations

import threading
from math import sqrt

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner.api.settings import own_keys
from rigrunner.jobs import InProcess, Processes
from rigrunner_bearings.api.rig import RigDescription
from rigrunner_bearings.compensations.settings import InverseSettings
from rigrunner_bearings.study import coverage_rigs
from rigrunner_bearings.study.bench import INERTIA, NATURAL
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.case_runner import CaseRunner
from rigrunner_bearings.study.coverage import (
    BANDS_HZ,
    METHODS,
    Finding,
    Outcome,
    cases,
    examine,
    is_sensor,
    limits,
    run_coverage,
    tally,
)
from rigrunner_bearings.study.coverage_plots import FIGURES, draw_figures
from rigrunner_bearings.study.coverage_rigs import FREQUENCIES_HZ, LAWS, RANGES, draw
from rigrunner_bearings.study.coverage_table import printed, study_document
from rigrunner_bearings.study.tables import markdown
from rigrunner_bearings.study.tools import SUPPORT_LIMIT, tools

pytestmark = pytest.mark.figures

SIM, ODE = RANGES
COUNT = len(FREQUENCIES_HZ)


def outcome(error, u=0.004, mean_expanded=0.008):
    errors = tuple(np.broadcast_to(error, COUNT).astype(float))
    return Outcome(errors, (u,) * COUNT, (2 * u,) * COUNT, float(np.mean(errors)), mean_expanded)


def finding(number=0, error=0.001, simulator=SIM, *, natural_hz=400.0, quiet=None):
    """Return a rig on which every method has this error."""
    all_errors = dict.fromkeys(METHODS, outcome(error))
    no_sensor = dict.fromkeys(METHODS, outcome(error if quiet is None else quiet))
    return Finding(Case(simulator, "", 1, number), "Stribeck", natural_hz, all_errors, no_sensor)


def drawn(simulator, number=0):
    rng = np.random.default_rng([number, 5])
    return draw(simulator, rng, tools().measured_station, limits())


def test_errors_and_coverage_are_counted():
    study = tally([finding(0, 0.003), finding(1, -0.004), finding(2, 0.009, quiet=0.001)])
    row = study.rows[0]
    assert (row.method, row.simulator, row.sensor, row.rigs) == (METHODS[0], "both", True, 3)
    assert row.error.bias == pytest.approx((0.003 - 0.004 + 0.009) / 3)
    assert row.error.rms == pytest.approx(sqrt((9 + 16 + 81) / 3) / 1000)
    assert row.error.largest == pytest.approx(0.009)
    assert row.coverage.rate == pytest.approx(2 / 3)
    assert (row.mean_coverage.hits, row.mean_coverage.of) == (2, 3)
    without = next(row for row in study.rows if not row.sensor)
    assert without.coverage.rate == 1.0


def test_rig_is_in_stratum_of_its_resonance():
    study = tally([finding(0, 0.001, natural_hz=250.0), finding(1, 0.02, natural_hz=300.0)])
    strata = [s for s in study.strata if s.method == METHODS[0] and s.sensor]
    rates = {(s.band_hz, s.frequency_hz): s.coverage.rate for s in strata}
    assert rates == {
        **{((200.0, 300.0), f): 1.0 for f in FREQUENCIES_HZ},
        **{((300.0, 450.0), f): 0.0 for f in FREQUENCIES_HZ},
    }


def test_refused_rig_is_counted_but_in_no_table():
    refused = Finding(Case(SIM, "", 1, 0), "Stribeck", 400.0, {}, {})
    study = tally([finding(1), refused])
    assert (study.rigs, study.refused) == (1, 1)
    with pytest.raises(DataError, match="no method could be used"):
        tally([refused])


@pytest.mark.parametrize("simulator", RANGES)
def test_drawn_errors_fill_limits_of_budget(simulator):
    """Rectangular within the stated limits, and not only near their middle."""
    allowed = InverseSettings()
    benches = [drawn(simulator, number) for number in range(400)]

    def changes(name):
        return np.array(
            [r.bench.loaded[name].number / r.bench.no_load[name].number for r in benches]
        )

    corner = np.array(
        [
            r.bench.no_load["sensors.low_pass"].number / r.station.instruments[0].low_pass.corner
            for r in benches
        ]
    )
    for ratio, limit in (
        (changes(INERTIA[simulator]), allowed.inertia_mismatch),
        (changes("support.friction"), SUPPORT_LIMIT),
        (corner, allowed.low_pass_tolerance),
    ):
        assert np.abs(ratio - 1).max() <= limit
        assert (ratio - 1).std() == pytest.approx(limit / sqrt(3), rel=0.1)


@pytest.mark.parametrize("simulator", RANGES)
def test_simulated_sensor_has_limits_of_register(simulator):
    rig = drawn(simulator)
    limit = rig.station.instruments[0].half_width
    settings = rig.bench.no_load
    assert settings["sensors.gain"].number / 100 == pytest.approx(limit("gain"))
    assert settings["sensors.drift"].number == pytest.approx(limit("drift"))
    silent = rig.without_sensor_errors
    for run in (silent.no_load, silent.loaded):
        assert all(run[name].number == 0 for name in coverage_rigs.SENSOR_ERRORS)
    assert silent.loaded["support.friction"] == rig.bench.loaded["support.friction"]


def test_station_knows_stroke_and_filter_of_rig():
    rig = drawn(SIM)
    assert own_keys(RigDescription, rig.station.rig).eccentric == pytest.approx(
        rig.bench.no_load["eccentric"].number / 1000
    )
    assert (
        rig.station.instruments[0].low_pass.corner != tools().station.instruments[0].low_pass.corner
    )


def test_all_laws_and_all_resonances_are_drawn():
    for simulator, laws in LAWS.items():
        rigs = [drawn(simulator, number) for number in range(200)]
        assert {rig.law for rig in rigs} == set(laws)
        natural = [rig.bench.no_load[NATURAL[simulator]].number for rig in rigs]
        assert min(sum(low <= f < high for f in natural) for low, high in BANDS_HZ) > 15


def test_cases_are_rigs_of_both_simulators():
    assert list(cases(2, 7)) == [Case(s, "", 7, n) for n in range(2) for s in RANGES]


@pytest.fixture(scope="module")
def one_rig():
    return examine(Case(SIM, "", 3, 0))


@pytest.mark.thorough
def test_rig_is_measured_with_and_without_sensor_errors(one_rig):
    for method in METHODS:
        all_errors, silent = one_rig.all_errors[method], one_rig.no_sensor[method]
        assert np.abs(all_errors.error_nm).max() < 0.03
        assert all_errors.error_nm != silent.error_nm
        assert all(a > b for a, b in zip(all_errors.u_nm, silent.u_nm, strict=True))
        assert all_errors.mean_error_nm == pytest.approx(np.mean(all_errors.error_nm))


@pytest.mark.thorough
def test_same_case_gives_same_finding(one_rig):
    assert examine(Case(SIM, "", 3, 0)) == one_rig


def test_sensor_lines_of_budget_are_recognized():
    assert is_sensor("sensor gain")
    assert not is_sensor("support friction under load")


@pytest.mark.thorough
def test_study_in_two_processes_is_the_same():
    progress = []

    def study(workers):
        never = threading.Event()
        runner = CaseRunner(workers, never, lambda *done: progress.append(done))
        return run_coverage(rigs=1, seed=4, runner=runner)

    first, second = study(InProcess()), study(Processes(2))
    assert study_document(first) == study_document(second)
    assert progress == [(0, 2), (1, 2), (2, 2)] * 2
    assert first.rigs == 2


def test_tables_and_document_agree():
    study = tally([finding(n, error) for n, error in enumerate([0.003, -0.004, 0.009])])
    text = markdown(printed(study))
    assert "3 rigs, half of each simulator." in text
    assert "| template_inverse | both (3) | with sensor term | 2.7 | 5.9 |" in text
    assert "66.7 % (9.4-99.2)" in text
    row = study_document(study)["methods"][0]
    assert row["runs_held"]["hits"] == 2
    assert row["error_nm"]["largest"] == 0.009


@pytest.mark.thorough
def test_figures_are_reproducible_to_the_byte(tmp_path):
    rigs = [finding(n, e, s) for n, e in enumerate((0.002, -0.005)) for s in (SIM, ODE)]
    study = tally(rigs)
    first, second = (draw_figures(study, tmp_path / name) for name in ("a", "b"))
    assert [path.stem for path in first] == list(FIGURES)
    for path, other in zip(first, second, strict=True):
        assert path.read_bytes() == other.read_bytes()
        assert path.read_bytes().startswith(b"<?xml")
