"""Prints the accuracy of each method on both simulated rigs: `python tests/benchmarks/accuracy.py`.

Twelve seeds, twelve frequencies, nominal parameters with noise; errors against the truth that the
simulators keep. The last column is the change of the mean torque from 10 Hz to 35 Hz. Takes about
two minutes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from rigrunner.signal.coverage import expanded
from rigrunner_bearings.compensations.inverse import ModelInverse, TemplateInverse
from rigrunner_bearings.compensations.settings import InverseSettings, TemplateInverseSettings
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import errors_nm, sweep_of

SEEDS = range(12)
RIGS = {"closed form": RigParameters(), "time domain": OdeParameters()}
METHODS = {
    "template_inverse": TemplateInverse(TemplateInverseSettings()),
    "model_inverse": ModelInverse(InverseSettings()),
}


def row(rig, method):
    outcomes = [METHODS[method](sweep_of(RIGS[rig], seed=seed)) for seed in SEEDS]
    errors = np.array([errors_nm(RIGS[rig], outcome) for outcome in outcomes])
    widths = np.array([[expanded(p.torque) for p in o.points] for o in outcomes])
    torques = np.array([[p.torque.value for p in o.points] for o in outcomes]).mean(axis=0)
    at_hz = [round(p.set_frequency_hz) for p in outcomes[0].points]
    spread = 100 * abs(torques[at_hz.index(35)] / torques[at_hz.index(10)] - 1)
    return (
        f"| {rig} | `{method}` | {1e3 * np.sqrt(np.mean(errors**2)):.1f}"
        f" | {1e3 * np.abs(errors).max():.1f} | {1e3 * np.median(widths):.1f}"
        f" | {np.sum(np.abs(errors) <= widths)} of {errors.size} | {spread:.2f} % |"
    )


def main() -> None:
    header = (
        "rig",
        "method",
        "RMSE",
        "greatest error",
        "median U (95 %)",
        "within U",
        "10 to 35 Hz",
    )
    sys.stdout.write(f"| {' | '.join(header)} |\n|{' --- |' * len(header)}\n")
    for rig in RIGS:
        for method in METHODS:
            sys.stdout.write(row(rig, method) + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
