"""The scatter of a zero reading: one error of all values that the zero was subtracted from."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, sqrt

import pytest

from rigrunner.analysis.verdict.limited_values import mean_of
from rigrunner.api.data import ZeroReading
from rigrunner.api.instruments import Instrument
from unit.rigrunner_plugins.equation import helpers_equation
from unit.rigrunner_plugins.test_curve import EXACT, results_of, rows, run_of
from unit.rigrunner_plugins.test_readings_of_two_runs import budget, compare, meter, voltages

CHANNEL, U, DOF = "meter.voltage", 0.3, 4.0


def with_zeros(run, zeros, channel=CHANNEL, u=U, numbers=None):
    """Return a run with a zero for each row; each zero scatters by u.

    Without `numbers`, rows with equal zeros have the same one.
    """
    order = list(dict.fromkeys(zeros))
    numbers = numbers or [order.index(zero) + 1 for zero in zeros]
    measured = tuple(
        replace(row, zeros={channel: ZeroReading(zero, number, u, DOF)})
        for row, zero, number in zip(run.measurements, zeros, numbers, strict=True)
    )
    return replace(
        run,
        measurements=measured,
        zeros={channel: zeros[-1]},
        zero_counts={channel: max(numbers)},
    )


def readings(run, **settings):
    return compare(run, run, **settings)


def test_scatter_of_zero_counts_once_in_a_mean():
    run = with_zeros(voltages(5.1, 5.3), [0.2, 0.2])
    estimate, lines = budget(readings(run))
    line = lines["scatter of zero of meter.voltage"]
    assert (line.u, line.dof, line.common) == (pytest.approx(U), DOF, True)
    u_readings = hypot(0.1, 0.03 / sqrt(3))  # two readings, and the meter's 30 mV
    assert estimate.u == pytest.approx(hypot(u_readings, U), rel=1e-6)


@pytest.mark.parametrize("zero", [0.0, 1e-9])
def test_reading_equal_to_its_zero_is_zero_after_the_correction(zero):
    """Also of exactly 0, such as that of an import whose program had subtracted it."""
    points = [{"applied": f"{i} V", "indicated": f"{i}.3 V", "U": "1 mV"} for i in (0, 10)]
    entry = {"channel": CHANNEL, "measures": "voltage", "serial": "1", "points": points}
    instrument = Instrument.model_validate({**entry, "interpolation": "linear"})
    run = with_zeros(voltages(zero, zero, instrument=instrument), [zero] * 2)
    assert budget(readings(run))[0].value == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("made_by", ["readings", "equation"])
def test_zero_without_scatter_has_the_resolution_of_the_instrument(made_by):
    """A display of 0.1 V is read twice: at rest, and at the value (EURAMET cg-18, 7.1.1)."""
    run = with_zeros(voltages(5.1, 5.1, instrument=meter(resolution="0.1 V")), [0.2] * 2, u=0.0)
    if made_by == "readings":
        estimate, lines = budget(readings(run))
    else:
        settings = {"result": {"name": "y", "unit": "V"}, "model": "y = U",
                    "inputs": {"U": CHANNEL}}  # fmt: skip
        estimate, lines = budget(helpers_equation.findings(settings, run))
    line = lines["resolution of zero of meter.voltage"]
    assert (line.u, line.distribution) == (pytest.approx(0.1 / sqrt(12)), "rectangular")
    assert estimate.u == pytest.approx(sqrt(2) * 0.1 / sqrt(12))


def test_zero_without_scatter_and_resolution_has_no_error():
    run = with_zeros(voltages(5.1, 5.1), [0.2] * 2, u=0.0)
    assert list(budget(readings(run))[1]) == ["scatter of the readings", "reading of meter.voltage"]


def test_scatter_of_zero_is_one_error_of_all_places():
    run = with_zeros(voltages(5.1, 5.1, 7.1, 7.1), [0.2] * 4)
    measured = tuple(
        replace(row, coordinates={"phase": "ab"[i // 2]}) for i, row in enumerate(run.measurements)
    )
    at_places = readings(replace(run, measurements=measured), per="phase").results
    assert [result.estimate.u > U for result in at_places] == [True, True]
    # equal readings do not scatter, and the meter's 30 mV are one error of both in the worst case
    assert mean_of(at_places).u == pytest.approx(hypot(U, 0.03 / sqrt(3)), rel=1e-6)


def test_equal_zeros_of_two_places_are_two_errors():
    run = with_zeros(voltages(5.1, 5.1, 7.1, 7.1), [0.2] * 4, numbers=[1, 1, 2, 2])
    measured = tuple(
        replace(row, coordinates={"phase": "ab"[i // 2]}) for i, row in enumerate(run.measurements)
    )
    at_places = readings(replace(run, measurements=measured), per="phase").results
    assert mean_of(at_places).u == pytest.approx(hypot(U / sqrt(2), 0.03 / sqrt(3)), rel=1e-6)


def test_equal_zeros_at_rest_are_rounded_alike():
    """Two readings of a display of 0.1 V, each after a zero: the mean is no better than one."""
    meters = {"instrument": meter(resolution="0.1 V")}
    once = with_zeros(voltages(5.1, **meters), [0.2], u=0.0)
    twice = with_zeros(voltages(5.1, 5.1, **meters), [0.2] * 2, u=0.0, numbers=[1, 2])
    estimate, lines = budget(readings(twice))
    assert lines["resolution of zero 1 of meter.voltage"].u == pytest.approx(0.1 / sqrt(12))
    assert estimate.u == pytest.approx(budget(readings(once))[0].u)


@pytest.mark.parametrize("statistic", ["range", "standard_deviation"])
def test_scatter_of_zero_cancels_in_a_spread(statistic):
    run = with_zeros(voltages(5.1, 5.3, 5.2), [0.2] * 3)
    _, lines = budget(readings(run, statistic=statistic))
    assert lines["scatter of zero of meter.voltage"].u == pytest.approx(0, abs=1e-9)


def test_each_of_two_zeros_moves_its_own_values():
    run = with_zeros(voltages(5.1, 5.3, 5.2, 5.2, 5.2), [0.2] * 2 + [0.1] * 3)
    _, lines = budget(readings(run))
    assert lines["scatter of zero 1 of meter.voltage"].u == pytest.approx(U * 2 / 5)
    assert lines["scatter of zero 2 of meter.voltage"].u == pytest.approx(U * 3 / 5)


def test_zero_before_each_reading_is_part_of_their_scatter():
    run = with_zeros(voltages(5.1, 5.3), [0.2, 0.1])
    _, lines = budget(readings(run))
    assert not [name for name in lines if "zero" in name]
    _, lines = budget(readings(with_zeros(voltages(5.1), [0.2])))  # one reading has no scatter
    assert lines["scatter of zero of meter.voltage"].u == pytest.approx(U)


def test_partner_run_has_its_own_zero():
    run, dark = with_zeros(voltages(5.1), [0.2]), with_zeros(voltages(0.2), [0.1])
    estimate, lines = budget(compare(run, dark, tare={"procedure": "DARK"}))
    assert lines["scatter of zero of meter.voltage"].u == pytest.approx(U)
    assert lines["scatter of zero of meter.voltage, tare run"].u == pytest.approx(U)
    u_meters = hypot(0.03 / sqrt(3), 0.03 / sqrt(3))
    assert estimate.u == pytest.approx(hypot(U, U, u_meters), rel=1e-6)


def test_equation_propagates_the_scatter_of_zero():
    columns = {CHANNEL: [5.1, 5.3]}
    run = helpers_equation.run_of(columns, {CHANNEL: "V"}, [meter()])
    settings = {
        "inputs": {"u": {"of": CHANNEL}},
        "model": "twice = 2 * u",
        "result": {"name": "twice", "unit": "V"},
    }
    (twice,) = helpers_equation.findings(settings, with_zeros(run, [0.2, 0.2])).results
    lines = {line.name: line for line in twice.components}
    line = lines["scatter of zero of meter.voltage"]
    assert (line.u, line.common, line.dof) == (pytest.approx(2 * U), True, pytest.approx(DOF))


def curve(y, zeros, numbers=None, **settings):
    run = run_of(rows([0.0, 1.0, 2.0, 3.0], y), EXACT)
    results = {
        "value": [{"name": "middle", "at": "1.5 N·m", "unit": "V"}],
        "slope": {"name": "slope", "unit": "V/(N·m)"},
    }
    return results_of(with_zeros(run, zeros, "cell.signal", numbers=numbers), results, **settings)


def test_curve_value_has_the_scatter_of_zero_and_the_slope_has_not():
    results = curve([1.0, 2.1, 2.9, 4.0], [0.0] * 4)
    u = {
        name: next(line.u for line in result.components if "zero" in line.name)
        for name, result in results.items()
    }
    assert u == {"middle": pytest.approx(U), "slope": pytest.approx(0, abs=1e-6)}


def test_zeros_of_two_halves_of_a_line_move_its_slope():
    result = curve([1.0, 2.1, 2.9, 4.0], [0.0, 0.0, 0.1, 0.1])["slope"]
    lines = [line.u for line in result.components if "zero" in line.name]
    # the weight of a y in the slope of 0, 1, 2, 3 is (x - 1.5)/5
    assert lines == [pytest.approx(U * 2 / 5), pytest.approx(U * 2 / 5)]


def test_zero_of_one_point_is_part_of_the_scatter_about_the_curve():
    for zeros in [0.0, 0.1, 0.2, 0.3], [0.2] * 4:
        result = curve([1.0, 2.1, 2.9, 4.0], zeros, numbers=[1, 2, 3, 4])["middle"]
        assert not [line for line in result.components if "zero" in line.name]


def test_equal_zeros_of_two_halves_move_the_slope():
    result = curve([1.0, 2.1, 2.9, 4.0], [0.2] * 4, numbers=[1, 1, 2, 2])["slope"]
    lines = [line.u for line in result.components if "zero" in line.name]
    assert lines == [pytest.approx(U * 2 / 5), pytest.approx(U * 2 / 5)]
