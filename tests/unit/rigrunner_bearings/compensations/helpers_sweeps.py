"""Prepared sweeps of the simulated rigs, for tests of compensations by whole swings."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from helpers_rigs import FREQUENCIES, INSTRUMENT, RIG, run_data, true_starting_torque_nm
from rigrunner_bearings.api.compensations import Sweep
from rigrunner_bearings.compensations.inverse import TemplateInverse
from rigrunner_bearings.compensations.settings import TemplateInverseSettings
from rigrunner_bearings.torque.prepare import prepare_point
from rigrunner_bearings.torque.settings import SwingTorque
from rigrunner_plugins.outlier_rules.rules import Grubbs
from rigrunner_plugins.outlier_rules.settings import GrubbsSettings

FEW = (1.0, 5.0, 10.0, 20.0, 30.0, 35.0)
SPEC = SwingTorque.model_validate({"despike": {"hampel": {"window": 11}}})


def no_fit(_points):
    raise AssertionError("a compensation by whole swings fits no peaks")


def prepared(parameters, load_n, frequencies=FREQUENCIES, seed=0):
    """Return the points of one run, as the analysis prepares them."""
    run = run_data(parameters, load_n, frequencies, seed)
    rule = Grubbs(GrubbsSettings())
    return tuple(prepare_point(recording, run, SPEC, rule) for recording in run.recordings)


@lru_cache(maxsize=16)  # the rigs of both studies, which two modules compensate
def sweep_of(parameters, frequencies=FREQUENCIES, seed=0, instrument=INSTRUMENT):
    """Return loaded and no-load run of one rig."""
    loaded = prepared(parameters, 1000.0, frequencies, seed)
    return Sweep(loaded, prepared(parameters, 0.0, frequencies, seed), RIG, instrument, no_fit)


def compensate(sweep, **settings):
    return TemplateInverse(TemplateInverseSettings.model_validate(settings))(sweep)


def errors_nm(parameters, compensation):
    """Return torque minus the simulator's truth, shape (points,)."""
    return np.array(
        [
            point.torque.value - true_starting_torque_nm(parameters, 1000.0, point.set_frequency_hz)
            for point in compensation.points
        ]
    )
