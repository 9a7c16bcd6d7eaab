from dataclasses import replace

import numpy as np
import pytest

from helpers_rigs import INSTRUMENT
from helpers_thorough import first
from rigrunner.api.errors import DataError
from rigrunner.api.instruments import Instrument
from rigrunner.signal.coverage import expanded
from rigrunner.signal.propagation import sensitivities
from rigrunner.signal.uncertainty import combine
from rigrunner_bearings.api.rig import SupportUnderLoad
from rigrunner_bearings.api.torque import DRIFT_LINE, SUPPORT_LINE
from rigrunner_bearings.compensations import identification
from rigrunner_bearings.compensations.comparison import SLIP
from rigrunner_bearings.compensations.drive_line import DriveLine
from rigrunner_bearings.compensations.settings import TemplateInverseSettings
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from rigrunner_bearings.torque.headline import compensated_mean
from unit.rigrunner_bearings.compensations.helpers_sweeps import (
    FEW,
    compensate,
    errors_nm,
    prepared,
    sweep_of,
)

RIG = RigParameters()


@pytest.fixture(scope="module")
def outcome():
    return compensate(sweep_of(RIG, FEW))


def check_of(outcome, name):
    return next(check for check in outcome.checks if check.name == name)


def broken(**changes):
    sensors = changes.pop("sensors", {})
    return RigParameters(sensors=replace(RIG.sensors, **sensors), **changes)


def test_parts_of_each_point_add_up(outcome):
    for point in outcome.points:
        assert point.rig_nm == pytest.approx(point.raw_nm - point.torque.value)
        assert (point.torque.u, point.torque.dof) == pytest.approx(combine(point.components))
        assert point.raw_nm > point.torque.value


def test_budget_marks_common_contributions(outcome):
    common = {part.name: part.common for part in outcome.points[-1].components}
    assert [name for name, is_common in common.items() if not is_common] == [
        "repeatability, loaded",
        "repeatability, no load",
        "frequency, loaded",
        "frequency, no load",
    ]
    assert {"sensor gain", "sensor non-linearity", "support friction under load"} <= set(common)


def test_sensor_gain_acts_on_difference(outcome):
    """0.3 % of about 0.726 N·m, rectangular."""
    gain = next(p for p in outcome.points[-1].components if p.name == "sensor gain")
    assert gain.u == pytest.approx(0.003 * 0.726 / np.sqrt(3), rel=0.03)


def test_number_of_drive_line_inversions_is_limited(monkeypatch):
    """Counts inversions: ten lines of two runs, four frequencies, and both scatters.

    Four more per point by the check of the drive line under load: the identified line, and those
    with another resonance, damping and delay; the inertia needs none. One more by the check of the
    inertia of both runs, for the effect of a gain. Seven more by the comparison of the runs: three
    of each, one of them again for the budget, and that without load for the effect of its gain.
    """
    calls = []
    plain = DriveLine.at_load
    monkeypatch.setattr(DriveLine, "at_load", lambda *args: calls.append(1) or plain(*args))
    outcome = compensate(sweep_of(RIG, FEW, seed=4))
    assert len(calls) <= (26 + 4 + 1 + 7) * len(outcome.points)


@pytest.mark.thorough
def test_drive_line_is_searched_twice_and_once_per_variant(monkeypatch):
    """With a delay and without; with another swing, another filter, and half of the frequencies."""
    searched = []
    plain = identification._search
    monkeypatch.setattr(
        identification, "_search", lambda *args: searched.append(args[-1]) or plain(*args)
    )
    compensate(sweep_of(RIG, seed=11))
    assert len(searched) == 6
    assert sum("delay_s" in unknowns for unknowns in searched) == 1


def unmeasured(sweep, **stated):
    """Return the sweep of a station that states nothing about its support except `stated`."""
    update = {"support_load_dependence": None, **stated}
    return replace(sweep, rig=sweep.rig.model_copy(update=update))


def support_line(point):
    (line,) = (part for part in point.components if part.name.startswith(SUPPORT_LINE))
    return line


def test_unmeasured_support_friction_grows_as_in_literature():
    """Between 0 and 2.5 % at 1000 N: a load raises friction, it does not lower it (GUM 4.3.7)."""
    sweep = sweep_of(RIG, FEW)
    unstated = unmeasured(sweep)
    for point, measured in zip(compensate(unstated).points, compensate(sweep).points, strict=True):
        line, measured_line = support_line(point), support_line(measured)
        assert "assumed" in line.name
        assert line.value == pytest.approx(0.0125)
        assert line.input_u == pytest.approx(0.0125 / np.sqrt(3))
        lowered = measured.torque.value - point.torque.value
        (slip,) = (part.u for part in point.components if part.name == SLIP)
        limit = -0.0125 * measured_line.sensitivity  # where the slip does not grow
        assert limit - 1e-3 - 2 * slip * np.sqrt(3) < lowered < limit


def line_of(point, name):
    """Return the one line of the budget whose name begins with `name`, or None."""
    lines = [part for part in point.components if part.name.startswith(name)]
    assert len(lines) <= 1
    return lines[0] if lines else None


def test_unmeasured_support_drift_is_triangular():
    """2 % a kelvin and two runs within +/- 2 K each: a triangle of +/- 8 % (JCGM 101, 6.4.5)."""
    sweep = replace(unmeasured(sweep_of(RIG, FEW)), apart=True)
    for point in compensate(sweep).points:
        drift = line_of(point, DRIFT_LINE)
        assert drift.name == f"{DRIFT_LINE} (assumed, not measured)"
        assert drift.input_u == pytest.approx(0.08 / np.sqrt(6))
        assert drift.sensitivity == pytest.approx(support_line(point).sensitivity)
        assert drift.common


MEASURED = SupportUnderLoad.model_validate(
    {"source": "R", "load": "1000 N", "torque": "10 mN·m", "u": "2 mN·m"}
)


@pytest.mark.parametrize(
    ("stated", "u"),
    [
        ({"support_drift": 0.02}, 0.02 / np.sqrt(3)),
        ({"support_drift": 0.0}, None),
        ({"support_load_dependence": 0.01}, None),
        ({"support_drift": 0.02, "support_load_dependence": 0.01}, 0.02 / np.sqrt(3)),
        ({"support_under_load": MEASURED}, None),
    ],
)
def test_station_may_state_support_drift(stated, u):
    sweep = replace(unmeasured(sweep_of(RIG, FEW), **stated), apart=True)
    drift = line_of(compensate(sweep).points[0], DRIFT_LINE)
    assert (drift is None) == (u is None)
    assert u is None or drift.input_u == pytest.approx(u)


def test_runs_of_one_setup_have_no_drift():
    assert line_of(compensate(unmeasured(sweep_of(RIG, FEW))).points[0], DRIFT_LINE) is None


@pytest.mark.parametrize("drift", first(1, [0.05, -0.05]))
def test_warmer_or_colder_support_is_within_uncertainty(drift):
    """Dry friction of 0.76 N·m that changed by 5 % moves the torque by some 30 mN·m."""
    warmer = replace(RIG, support_friction_nm=RIG.support_friction_nm * (1 + drift))
    sweep = replace(sweep_of(RIG, FEW), loaded=prepared(warmer, 1000.0, FEW), apart=True)
    stated = compensate(sweep)
    honest = compensate(unmeasured(sweep))
    mean, wide = (compensated_mean(outcome.points) for outcome in (stated, honest))
    error = errors_nm(warmer, stated).mean()
    assert abs(error) > 2 * expanded(mean)
    assert abs(errors_nm(warmer, honest).mean()) < expanded(wide)


@pytest.mark.thorough
def test_changed_build_up_of_support_friction_is_flagged():
    """Friction that builds up over half the travel under load: the torque is 0.3 N·m too great."""
    stiffer = replace(RIG, support_slip_rad=RIG.support_slip_rad / 2)
    wide = replace(RIG, support_slip_rad=2 * RIG.support_slip_rad)
    sweep = sweep_of(wide, FEW)
    sweep = replace(sweep, loaded=prepared(stiffer, 1000.0, FEW))
    name = "build-up of the support's friction"
    build_up = check_of(compensate(unmeasured(sweep)), name)
    assert not build_up.ok
    assert build_up.value > 6
    assert min(bias.value for bias in build_up.biases) > 0.02
    assert check_of(compensate(sweep), name).ok
    assert check_of(compensate(unmeasured(sweep_of(RIG, FEW))), name).ok


def test_assumed_growth_is_proportional_to_load_above_1000_n():
    sweep = unmeasured(sweep_of(RIG, FEW))
    heavy, light = (
        replace(sweep, loaded=tuple(replace(point, load_n=load_n) for point in sweep.loaded))
        for load_n in (2000.0, 400.0)
    )
    assert support_line(compensate(heavy).points[0]).value == pytest.approx(0.025)
    assert support_line(compensate(light).points[0]).value == pytest.approx(0.0125)


def test_measured_growth_scales_with_load():
    sweep = sweep_of(RIG, FEW)
    measured = {
        "support_load_growth": 0.02,
        "support_load_dependence": 0.004,
        "support_load": 2000.0,
        "support_load_source": "run 4711 of 2026-11-20",
    }
    measured_rig = replace(sweep, rig=sweep.rig.model_copy(update=measured))
    line = support_line(compensate(measured_rig).points[0])
    assert line.name == f"{SUPPORT_LINE} (run 4711 of 2026-11-20)"
    assert line.value == pytest.approx(0.01)
    assert line.input_u == pytest.approx(0.002 / np.sqrt(3))


def test_growth_without_limit_of_error_is_refused():
    with pytest.raises(ValueError, match="needs support_load_dependence"):
        TemplateInverseSettings.model_validate({"support_load_growth": "2 %"})


def test_settings_set_uncertainty_of_support_friction():
    sweep = unmeasured(sweep_of(RIG, FEW))
    free = compensate(sweep, support_load_dependence="0 %")
    strict = compensate(sweep, support_load_dependence="5 %")

    def parts(outcome):
        return {part.name: part.u for part in outcome.points[-1].components}

    assert parts(free)["support friction under load"] == 0
    # A support whose friction is 5 % greater under load moves the result of this rig by 31 mN·m,
    # not by 38: where the maximum is, its dry friction of 0.76 N·m is not fully built up.
    assert parts(strict)["support friction under load"] == pytest.approx(
        0.031 / np.sqrt(3), rel=0.05
    )


def test_station_values_override_defaults():
    sweep = sweep_of(RIG, FEW)
    rig = sweep.rig.model_copy(update={"support_load_dependence": 0.03, "load_tolerance": 0.01})
    names = ("support friction under load", "load")
    default, stated = (
        {part.name: part for part in compensate(variant).points[-1].components}
        for variant in (sweep, replace(sweep, rig=rig))
    )
    for name, times in zip(names, (3, 2), strict=True):
        assert stated[name].u == pytest.approx(times * default[name].u, rel=0.02)
        assert stated[name].sensitivity == pytest.approx(default[name].sensitivity, rel=0.02)


def test_angle_scale_error_matches_its_budget_line():
    sweep = sweep_of(RIG, FEW)
    scaled = replace(
        sweep,
        loaded=tuple(replace(point, angle_rad=1.005 * point.angle_rad) for point in sweep.loaded),
        no_load=tuple(replace(point, angle_rad=1.005 * point.angle_rad) for point in sweep.no_load),
    )
    as_seen, as_is = (compensate(variant).points for variant in (sweep, scaled))
    for seen, real in zip(as_seen, as_is, strict=True):
        line = next(part for part in seen.components if part.name == "angle scale")
        assert line.input_u == pytest.approx(0.005 / np.sqrt(3))
        moved = real.torque.value - seen.torque.value
        assert 0.005 * line.sensitivity == pytest.approx(moved, abs=3e-4)


def test_common_offset_cancels(outcome):
    offset = next(p for p in outcome.points[0].components if p.name == "sensor offset")
    assert (offset.input_u, offset.sensitivity, offset.u) == (
        pytest.approx(0.02 / np.sqrt(3)),
        0,
        0,
    )


def test_accuracy_of_full_scale_is_one_rectangular_line():
    sweep = sweep_of(RIG, FEW)
    sensor = Instrument.model_validate(
        {
            "channel": "tester.torque",
            "serial": "SIM-TQ-01",
            "full_scale": "10 N·m",
            "accuracy": "0.5 % FS",
            "low_pass": {"corner": "1 kHz"},
        }
    )
    (part,) = (
        part
        for part in compensate(replace(sweep, instrument=sensor)).points[0].components
        if part.name == "sensor accuracy"
    )
    assert (part.u, part.distribution) == (pytest.approx(0.005 * 10 / np.sqrt(3)), "rectangular")


def test_identified_rig_is_one_budget_line(outcome):
    model = outcome.points[-1].model
    learned = [item for item in model.inputs if item.budget_line == "resonance, damping, inertia"]
    assert [item.unit for item in learned] == ["Hz", "1", "kg·m²", "1", "s"]
    (line,) = (p for p in outcome.points[-1].components if p.name == "resonance, damping, inertia")
    rows = [model.inputs.index(item) for item in learned]
    gradient = sensitivities(model)[rows] * [item.u for item in learned]
    assert line.u == pytest.approx(
        np.sqrt(gradient @ model.correlation[np.ix_(rows, rows)] @ gradient)
    )
    assert line.dof == learned[0].dof


def test_model_value_equals_torque(outcome):
    for point in outcome.points:
        assert point.model.value == point.torque.value


def test_mean_accounts_for_correlation_of_points(outcome):
    """Its u is between that of independent points and that of fully correlated ones."""
    mean = compensated_mean(outcome.points).u
    points = outcome.points
    assert mean < np.mean([p.torque.u for p in points])
    assert mean > np.sqrt(sum(p.torque.u**2 for p in points)) / len(points)


def test_parameters_have_units_and_uncertainty(outcome):
    natural = outcome.parameters["natural frequency"]
    assert natural.unit == "Hz"
    assert natural.value == pytest.approx(400, abs=2)
    assert 0 < natural.u < 2
    assert outcome.parameters["inertia"].unit == "kg·m²"


def test_trace_covers_whole_swing(outcome):
    trace = outcome.points[-1].trace
    shapes = {a.shape for a in (trace.angle_rad, trace.raw_nm, trace.no_load_nm)}
    assert shapes == {trace.compensated_nm.shape}
    assert np.ptp(trace.raw_nm) > 10 * np.abs(trace.compensated_nm).max()


def test_good_rig_passes_every_check(outcome):
    bad = [check.name for check in outcome.checks if not check.ok]
    assert bad in ([], ["cycles"]), "10 cycles at 1 Hz, of which a gross error may take one"


def test_changed_inertia_is_found_and_removed():
    """1 % of the inertia is 50 mN·m at the reversal at 35 Hz, some 6 U; here at most U is left."""
    rig = broken(loaded_inertia_change=0.01)
    outcome = compensate(sweep_of(rig, FEW))
    changed = outcome.parameters["change of the inertia"]
    assert changed.value == pytest.approx(0.01, abs=2 * changed.u)
    assert changed.u < 0.002
    for error, point in zip(errors_nm(rig, outcome), outcome.points, strict=True):
        assert abs(error) < expanded(point.torque)


def test_one_sided_torque_fails_symmetry_check():
    outcome = compensate(sweep_of(broken(asymmetry_nm=0.08), FEW))
    assert not check_of(outcome, "symmetry of the strokes").ok


def test_slow_sampling_is_flagged():
    outcome = compensate(sweep_of(broken(sensors={"sample_rate_hz": 5e3}), FEW))
    check = check_of(outcome, "sampling of the resonance")
    assert not check.ok
    assert check.value == pytest.approx(5e3 / RIG.natural_hz, rel=0.01)
    assert check.threshold == 25


def test_swapped_runs_give_negative_torque():
    sweep = sweep_of(RIG, FEW)
    swapped = replace(sweep, loaded=sweep.no_load, no_load=sweep.loaded)
    outcome = compensate(swapped)
    check = check_of(outcome, "torque above zero")
    assert not check.ok
    assert check.text.count("-0.6") == len(FEW), "delivers energy at every frequency"


@pytest.mark.parametrize(
    "rig",
    first(
        2,
        [
            broken(stribeck=True),
            broken(zero_load_torque_nm=0.1),
            broken(damping_ratio=0.01),
            broken(sensors={"torque_delay_s": 1e-4}),
            broken(sensors={"speed_jitter": 5e-4, "encoder_noise_rad": 5e-5}),
            broken(sensors={"frequency_error": 0.05}),
        ],
    ),
    ids=["Stribeck", "friction at no load", "little damping", "delay", "jitter", "wrong entry"],
)
def test_faults_that_break_other_methods_are_compensated(rig):
    outcome = compensate(sweep_of(rig, FEW))
    assert np.abs(errors_nm(rig, outcome)).max() < 0.02


@pytest.mark.thorough
def test_slow_filter_in_register_is_inverted():
    rig = broken(sensors={"low_pass_hz": 200.0})
    low_pass = INSTRUMENT.low_pass.model_copy(update={"corner": 200.0})
    slow = INSTRUMENT.model_copy(update={"low_pass": low_pass})
    outcome = compensate(sweep_of(rig, FEW, 0, slow))
    assert np.abs(errors_nm(rig, outcome)).max() < 0.02


@pytest.mark.thorough
def test_paired_frequencies_may_differ_slightly():
    sweep = sweep_of(RIG, (1.0, 5.0, 10.0, 20.0, 30.0, 35.0))
    other_sweep = sweep_of(RIG, (1.0, 5.0, 10.1, 20.2, 30.3, 35.4))
    outcome = compensate(replace(sweep, no_load=other_sweep.no_load))
    assert np.abs(errors_nm(RIG, outcome)).max() < 0.02


def test_refuses_register_without_low_pass():
    unknown = INSTRUMENT.model_copy(update={"low_pass": None})
    with pytest.raises(DataError) as caught:
        compensate(replace(sweep_of(RIG, FEW), instrument=unknown))
    message = str(caught.value)
    assert "no low_pass for tester.torque (serial SIM-TQ-01)" in message
    assert "low_pass: {type: butterworth, order: 2, corner: 1 kHz}" in message


@pytest.mark.thorough  # as the kit's same_recordings_same_numbers
def test_same_input_gives_same_numbers():
    sweep = sweep_of(RIG, FEW)
    first, second = compensate(sweep), compensate(sweep)
    assert [p.torque for p in first.points] == [p.torque for p in second.points]
