"""The error of misaligned clocks: the table of docs/evidence/clocks.md.

    python tests/benchmarks/alignment.py [draws]

Not a test: it takes minutes. Each recording of a simulated sweep is shifted in time by a random
normal error; the starting torque is compared with the simulator's truth.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from helpers_rigs import true_starting_torque_nm
from rigrunner_bearings.compensations.inverse import TemplateInverse
from rigrunner_bearings.compensations.settings import TemplateInverseSettings
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from rigrunner_bearings.torque.clocks import SHARE
from rigrunner_bearings.torque.phase import ALIGNMENT, _torques, _Trial
from unit.rigrunner_bearings.compensations.helpers_sweeps import sweep_of

FREQUENCIES = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0)
MICROSECONDS = (0, 2, 5, 10, 20, 50, 100, 200)
METHOD = TemplateInverse(TemplateInverseSettings())


def shifted(points, u_s, rng):
    for point in points:
        phase_rad = 2 * np.pi * point.frequency_hz.value * u_s * rng.standard_normal()
        spectrum = np.fft.rfft(point.torque_nm, axis=-1)
        spectrum = spectrum * np.exp(-1j * phase_rad * np.arange(spectrum.shape[-1]))
        torque = np.fft.irfft(spectrum, point.torque_nm.shape[-1], axis=-1)
        yield replace(point, torque_nm=torque, alignment_u_s=u_s)


def drawn(rig, u_s, seed):
    """Return error, stated U with and without the alignment (points,), and the check's value."""
    rng = np.random.default_rng([seed, round(1e6 * u_s)])
    sweep = sweep_of(rig, FREQUENCIES, 1)
    loaded, no_load = (tuple(shifted(run, u_s, rng)) for run in (sweep.loaded, sweep.no_load))
    shifted_sweep = replace(sweep, loaded=loaded, no_load=no_load)
    outcome = METHOD(shifted_sweep)
    torque, u = _torques(outcome), np.array([point.torque.u for point in outcome.points])
    effect = _Trial(METHOD, shifted_sweep, torque).effects()[ALIGNMENT]
    truth = [true_starting_torque_nm(rig, 1000.0, hz) for hz in FREQUENCIES]
    ratio = float(np.max(effect / (SHARE * np.abs(torque))))
    return torque - truth, 2 * np.hypot(u, effect), 2 * u, ratio


def main(draws: int) -> None:
    for rig in (RigParameters(), OdeParameters()):
        for microseconds in MICROSECONDS:
            rows = [drawn(rig, 1e-6 * microseconds, seed) for seed in range(draws)]
            error, u_with, u_without = (np.abs([row[i] for row in rows]) for i in range(3))
            ratios = [row[3] for row in rows]
            print(  # noqa: T201  (the output of this script)
                f"| {type(rig).__name__} | {microseconds} us"
                f" | {1e3 * np.sqrt(np.mean(error**2)):.1f}"
                f" | {1e3 * np.sqrt(np.mean(error[:, -1] ** 2)):.1f}"
                f" | {np.mean(error <= u_with):.0%} | {np.mean(error <= u_without):.0%}"
                f" | {min(ratios):.2f} to {max(ratios):.2f} |"
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 6)
