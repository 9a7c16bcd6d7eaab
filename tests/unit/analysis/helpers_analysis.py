"""Runs of exactly known content, and their analysis with the settings of a procedure."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from rigrunner.analysis.analyse import analyse
from rigrunner.api.data import Estimate, Recording, RunData
from rigrunner.api.instruments import Instrument
from rigrunner.procedure import Acceptance, Measurand
from rigrunner.registry import load_registry
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.api.rig import RigDescription
from rigrunner_bearings.signal.kinematics import swing_angle
from unit.analysis import helpers_runs

RATIO = 2 / 45
RATE_HZ = 2000.0
MEASURAND = Measurand(symbol="Td", name="load-induced starting torque")
PAPER_PEAK = {"paper_peak": {"coefficients": "refit"}}
AT_REVERSAL = {"nature": "load_induced", "condition": "at_reversal"}
SPEC = {
    "despike": {"hampel": {"window": 11}},
    "outliers": {"grubbs": {"alpha": 0.05}},
    "fits": [{"polynomial": {"degree": 2}}, "inertia_physical"],
}
LOADED_SPEC = SPEC | {
    "no_load": {"from": "latest", "procedure": "SSPB-NLI"},
    "compensations": [PAPER_PEAK],
    "primary": "paper_peak",
}
RIG_KEYS = {
    "mandrel": "M-01",
    "eccentric": "2 mm",
    "centre_distance": "45 mm",
    "inertia": "0.00233 kg·m²",
    "support_friction": "0.76 N·m",
    "support_damping": "0.31 N·m·s/rad",
    "swing_radius": "10.4 mm",
}
RIG = RigDescription.model_validate(RIG_KEYS)


def instrument(
    *, full_scale="10 N·m", gain="0 %", drift="0 N·m", nonlinearity="0 %", offset="0 N·m"
):
    accuracy = {"gain": gain, "offset": offset, "drift": drift, "nonlinearity": nonlinearity}
    return Instrument.model_validate(
        {
            "channel": "tester.torque",
            "serial": "T-1",
            "full_scale": full_scale,
            "accuracy": accuracy,
            "low_pass": {"type": "butterworth", "order": 2, "corner": "1 kHz"},
        }
    )


def recording(peaks_nm, frequency_hz=10.0, *, load_n=1000.0, zero_nm=0.0, lead=0.4) -> Recording:
    """Return a recording whose cycle k has the torque peaks_nm[k] * cos(phi - 60 deg).

    It starts `lead` of a cycle early and ends as much late, so that len(peaks_nm) are complete.
    """
    count = len(peaks_nm)
    turns = np.arange(-lead, count + lead, frequency_hz / RATE_HZ)
    phase = 2 * np.pi * turns
    amplitude = np.asarray(peaks_nm)[np.clip(np.floor(turns), 0, count - 1).astype(int)]
    torque = amplitude * np.cos(phase - np.pi / 3) + zero_nm
    return Recording(
        name=f"{frequency_hz:g}Hz",
        rate_hz=RATE_HZ,
        started_utc="2026-01-01T12:00:00+00:00",
        setpoints={"tester.frequency": frequency_hz, "tester.load": load_n},
        channels={"tester.angle": swing_angle(phase, RATIO), "tester.torque": torque},
        units={"tester.angle": "rad", "tester.torque": "N·m"},
        conditions={"tester.load": load_n + 1.5},
    )


def run_of(*recordings, **changes) -> RunData:
    """Return a run of the swing tester."""
    torque = {"instruments": {"tester.torque": instrument()}, "zeros": {"tester.torque": 0.0}}
    return helpers_runs.run_of(*recordings, **({"rig_keys": RIG_KEYS} | torque | changes))


def swing_point(peaks_nm, frequency_hz, *, load_n=1000.0) -> SwingPoint:
    """Return a prepared point with these peaks, for peak methods."""
    peaks = np.asarray(peaks_nm, float)
    is_kept = np.ones(len(peaks), bool)
    phase = np.arange(8) * np.pi / 4
    return SwingPoint(
        recording=f"{frequency_hz:g}Hz",
        set_frequency_hz=frequency_hz,
        frequency_hz=Estimate(frequency_hz, 0.0, np.inf, "Hz"),
        load_n=load_n,
        sample_rate_hz=RATE_HZ,
        angle_rad=swing_angle(phase, RATIO),
        torque_nm=np.outer(peaks, np.cos(phase)),
        kept=is_kept,
        waveform_rejections=(),
        peak_nm=peaks,
        peak_kept=is_kept,
        peak_rejections=(),
        spikes=0,
    )


def _swing_torque():
    from rigrunner_bearings.torque.settings import SwingTorque  # noqa: PLC0415  (may be missing)

    return SwingTorque


def spec(**changes):
    return _swing_torque().model_validate(LOADED_SPEC | changes)


def no_load_spec(**changes):
    return _swing_torque().model_validate(SPEC | changes)


def acceptance(maximum="0.95 N·m", minimum=None, rule="guard_band_u") -> Acceptance:
    limit = {"of": "torque", "mean": True, "source": "a test", "measurand": AT_REVERSAL}
    ends = {"max": maximum, "min": minimum}
    bounds = {name: value for name, value in ends.items() if value is not None}
    return Acceptance.model_validate({"limits": [limit | bounds], "rule": rule})


def analysed(run, no_load=None, analysis_spec=None, accept=None):
    from rigrunner_bearings.study.tools import analysis_ref  # noqa: PLC0415  (may be missing)

    settings = analysis_spec or (spec() if no_load is not None else no_load_spec())
    if no_load is not None:
        run = replace(run, partners={"no_load": no_load})
    refs = (analysis_ref(settings),)
    return analyse(run, refs, acceptance=accept, measurand=MEASURAND, lookup=registry())


@lru_cache(maxsize=1)
def registry():
    return load_registry()
