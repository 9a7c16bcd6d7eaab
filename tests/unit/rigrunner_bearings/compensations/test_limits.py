"""The support's friction due to the load is subtracted at each point by its own load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from helpers_rigs import RIG
from rigrunner_bearings.api.rig import SupportUnderLoad
from rigrunner_bearings.compensations.energy import Energy
from rigrunner_bearings.compensations.inverse import TemplateInverse
from rigrunner_bearings.compensations.limits import support_growth, support_under_load
from rigrunner_bearings.compensations.settings import EnergySettings, TemplateInverseSettings
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import FEW, compensate, sweep_of

SETTINGS = TemplateInverseSettings()
LOADS_N = (500.0, 500.0, 500.0, 1000.0, 1003.0, 2000.0)
MEASURED = SupportUnderLoad.model_validate(
    {"source": "R", "load": "1000 N", "torque": "10 mN·m", "u": "2 mN·m"}
)


def under(loads_n, **stated):
    """Return a sweep whose points are under these loads, on a rig that states this."""
    sweep = sweep_of(RigParameters(), FEW)
    loaded = tuple(
        replace(point, load_n=load_n) for point, load_n in zip(sweep.loaded, loads_n, strict=True)
    )
    stated = {"support_load_dependence": None, **stated}
    return replace(sweep, loaded=loaded, rig=RIG.model_copy(update=stated))


def test_measured_torque_is_proportional_to_each_load():
    support = support_under_load(SETTINGS, under(LOADS_N, support_under_load=MEASURED))
    # Readings of 1000 N and 1003 N are one nominal load.
    assert support.torques_nm == pytest.approx((0.005, 0.005, 0.005, 0.01003, 0.01003, 0.02))
    assert support.measured.u == pytest.approx(0.004)


def test_growth_stated_for_a_load_is_proportional_to_each_load():
    stated = {
        "support_load_growth": 0.02,
        "support_load_dependence": 0.004,
        "support_load": 1000.0,
    }
    support = support_growth(SETTINGS, under(LOADS_N, **stated))
    growths = [support.growth * share for share in support.at_points]
    assert growths == pytest.approx([0.01, 0.01, 0.01, 0.02006, 0.02006, 0.04])


def test_assumed_growth_is_constant_below_the_reference_load():
    support = support_growth(SETTINGS, under(LOADS_N))
    limits = [support.limit * share for share in support.at_points]
    assert limits == pytest.approx([0.0125, 0.0125, 0.0125, 0.0125 * 1.003, 0.0125 * 1.003, 0.025])


def test_growth_without_a_load_is_equal_at_all_points():
    stated = {"support_load_growth": 0.02, "support_load_dependence": 0.004}
    assert support_growth(SETTINGS, under(LOADS_N, **stated)).at_points == (1.0,) * len(FEW)


def test_readings_of_one_nominal_load_share_one_growth():
    sweep = under((999.0, 1000.0, 1001.0, 998.5, 1000.5, 999.5), support_under_load=MEASURED)
    assert support_under_load(SETTINGS, sweep).torques_nm == pytest.approx((0.01001,) * 6)


def test_starting_torques_are_corrected_by_their_own_load():
    loads_n = (500.0,) * 3 + (1000.0,) * 3
    none = MEASURED.model_copy(update={"torque": 0.0, "u": 0.0})
    method = TemplateInverse(SETTINGS)
    sweep, without = (under(loads_n, support_under_load=each) for each in (MEASURED, none))
    expected = [0.005] * 3 + [0.01] * 3
    assert method.torques(without) - method.torques(sweep) == pytest.approx(expected)
    differences = [
        before.torque.value - after.torque.value
        for before, after in zip(compensate(without).points, compensate(sweep).points, strict=True)
    ]
    assert differences == pytest.approx(expected)


def test_running_torques_are_corrected_by_their_own_load():
    loads_n = (500.0,) * 3 + (1000.0,) * 3
    stated = {"support_load_dependence": 0.0, "support_load": 1000.0}
    values = []
    for growth in (0.0, 0.02):
        sweep = under(loads_n, **stated, support_load_growth=growth)
        compensation = Energy(EnergySettings())(sweep)
        values.append(np.array([point.torque.value for point in compensation.points]))
    subtracted = values[0] - values[1]
    assert subtracted[:3] == pytest.approx(subtracted[3] / 2, rel=0.01)
    assert subtracted[3:] == pytest.approx(subtracted[3], rel=0.01)


def test_load_readings_about_zero_have_a_growth():
    sweep = under((-0.3, 0.2, -0.1, 0.0, 0.4, 0.1))
    assert support_growth(SETTINGS, sweep).at_points == (1.0,) * len(FEW)
    support = support_under_load(SETTINGS, under((-0.3,) * len(FEW), support_under_load=MEASURED))
    assert support.torques_nm == pytest.approx((-3e-6,) * len(FEW))
