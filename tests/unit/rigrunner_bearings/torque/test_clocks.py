"""Uncertain alignment of torque and angle clocks, on a method with a known response to a shift."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate, Recording
from rigrunner.api.errors import DataError
from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation, Sweep
from rigrunner_bearings.api.points import PeakPoint
from rigrunner_bearings.signal.swings import with_swings
from rigrunner_bearings.torque.clocks import CLOCKS, SHARE, alignment_u_s, alignments
from rigrunner_bearings.torque.phase import ALIGNMENT, CLOCK_NOTE, compensated
from unit.analysis.helpers_analysis import RIG, instrument, swing_point

HERTZ = 10.0
BASE = Component("scatter", 0.01, 9.0, "normal", common=False)
TORQUE_NM = 2.0


def difference(sweep):
    """A method: a torque of 2 N·m, and the difference of the sine parts of both runs."""
    swings = with_swings(sweep)
    values = [
        TORQUE_NM + _sine_nm(loaded) - _sine_nm(no_load)
        for loaded, no_load in zip(swings.loaded, swings.no_load, strict=True)
    ]
    return Compensation("sine", tuple(_point_of(value) for value in values))


def peaks(sweep):
    return Compensation("peak", tuple(_point_of(p.peak_nm.mean()) for p in sweep.loaded))


def _sine_nm(point):
    """Return the first harmonic's sine part: linear in a small shift of a cosine."""
    mean = point.torque_nm.mean(axis=0)
    return -2 * np.fft.rfft(mean)[1].imag / len(mean)


def _point_of(value):
    return CompensatedPoint(HERTZ, HERTZ, value, 0.0, Estimate(value, BASE.u, BASE.dof), (BASE,))


def sweep_of(u_s):
    """Return a sweep of cos(phi), amplitude 3 loaded and 1 without load, aligned to `u_s`."""
    loaded = replace(swing_point(np.full(6, 3.0), HERTZ), alignment_u_s=u_s)
    no_load = replace(swing_point(np.full(6, 1.0), HERTZ, load_n=0.0), alignment_u_s=u_s)
    return Sweep((loaded,), (no_load,), RIG, instrument(), lambda _: None)


def effect_nm(u_s):
    """The independent errors of both runs: hypot(3, 1) times a small angle of the cycle."""
    return np.hypot(3, 1) * 2 * np.pi * HERTZ * u_s


TOLERATED_S = SHARE * TORQUE_NM / effect_nm(1.0)


def test_tolerable_misalignment_is_a_budget_line():
    u_s = 0.5 * TOLERATED_S
    compensation = compensated(difference, sweep_of(u_s))
    (line,) = (c for c in compensation.points[0].components if c.name == ALIGNMENT)
    assert line.u == pytest.approx(effect_nm(u_s), rel=1e-3)
    assert not line.common
    assert compensation.checks[-1].ok
    assert compensation.checks[-1].value == pytest.approx(0.5, rel=1e-3)
    assert CLOCK_NOTE in compensation.notes
    assert compensation.not_applicable == ""


def test_intolerable_misalignment_is_refused_with_limits():
    u_s = 2 * TOLERATED_S
    compensation = compensated(difference, sweep_of(u_s))
    assert compensation.points == ()
    assert f"aligned to {1e3 * u_s:.2g} ms" in compensation.not_applicable
    assert f"at 10 Hz {1e3 * TOLERATED_S:.2g} ms is allowed" in compensation.not_applicable
    assert "record torque and angle with one instrument" in compensation.not_applicable
    (check,) = compensation.checks
    assert (check.name, check.ok, check.decisive) == (CLOCKS.name, False, True)
    assert check.text == f"10 Hz: {1e3 * u_s:.2g} ms, allowed {1e3 * TOLERATED_S:.2g} ms"
    assert check.value == pytest.approx(2.0, rel=1e-2)


def test_single_value_has_no_clock_uncertainty():
    value = PeakPoint(
        recording="table 1",
        set_frequency_hz=HERTZ,
        frequency_hz=Estimate(HERTZ, 0.0, unit="Hz"),
        load_n=0.0,
        peak_nm=np.ones(1),
        peak_kept=np.ones(1, dtype=bool),
    )
    (alignment,) = alignments((_point_of(TORQUE_NM),), (value,), np.zeros(1))
    assert (alignment.u_s, alignment.effect) == (0.0, 0.0)


def test_misalignment_of_whole_cycle_is_refused():
    compensation = compensated(difference, sweep_of(1 / HERTZ))
    assert compensation.not_applicable


def test_methods_without_phase_are_unaffected():
    compensation = compensated(peaks, sweep_of(1.0))
    assert compensation.points
    assert compensation.checks == ()


def test_one_clock_needs_no_check():
    compensation = compensated(difference, sweep_of(0.0))
    assert compensation.checks == compensation.notes == ()


def test_uncertainty_combines_both_channels():
    conditions = {"tester.angle_alignment_u": 3e-6, "tester.torque_alignment_u": 4e-6}
    recording = Recording("001", 1e4, "", {}, {}, {}, conditions)
    assert alignment_u_s(recording, "tester.torque", "tester.angle") == pytest.approx(5e-6)
    assert alignment_u_s(recording, "tester.torque", "tester.tacho") == pytest.approx(4e-6)
    assert alignment_u_s(recording, "other.torque", "other.angle") == 0.0


def test_failure_on_two_clocks_mentions_the_clocks():
    def failing(_sweep):
        raise DataError("no reversal", hint="look at the signal")

    with pytest.raises(DataError, match="no reversal; torque and angle were sampled by two clocks"):
        compensated(failing, sweep_of(4.1e-3))
    with pytest.raises(DataError, match=r"^no reversal \(look at the signal\)$"):
        compensated(failing, sweep_of(0.0))
