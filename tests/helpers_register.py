"""A station whose tester counts as a real device, with a register to spoil."""

from __future__ import annotations

from helpers_workflow import START, quick_procedure, station_file
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.workflow.prepare import plan_run

BENCH_PLUGIN = """
from dataclasses import replace

from rigrunner.api.hooks import hookimpl
from rigrunner_plugins import hooks

api_version = 1


@hookimpl
def rigrunner_devices():
    sim = next(each for each in hooks.rigrunner_devices() if each.name == "swing_tester_sim")
    return [replace(sim, name="bench_tester", simulated=False)]
"""
TORQUE = """
    id: TQ-7
    certificate: D-K-1
    laboratory: A lab
    calibrated: 2025-06-01
    due: 2026-06-01
"""
OTHERS = """
  - channel: tester.angle
    measures: angle
    serial: A-1
    certificate: D-K-2
    due: 2026-06-01
    range: {min: -5 deg, max: 5 deg}
    accuracy: 0.01 deg
  - channel: tester.load
    measures: force
    id: LC-3
    serial: L-1
    certificate: D-K-3
    due: 2026-06-01
    range: {min: 100 N, max: 5 kN}
    accuracy: 0.1 % FS
"""


def bench(folder, *changes):
    """Write a station with a real tester, all instruments calibrated, and then changed."""
    (folder / "lab").mkdir(exist_ok=True)
    (folder / "lab" / "bench.py").write_text(BENCH_PLUGIN)
    path = station_file(
        folder,
        ("id: simulated\n", "id: bench\nplugins: lab\n"),
        ("plugin: swing_tester_sim", "plugin: bench_tester"),
    )
    lines = path.read_text(encoding="utf-8").rstrip().splitlines()
    kept = "\n".join(line for line in lines if not line.strip().startswith("calibration:"))
    text = kept.replace("\n    serial: SIM-TQ-01", f"\n    serial: T-1{TORQUE.rstrip()}") + OTHERS
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path


def planned(folder, station, name="starting_torque_1000n", *changes):
    """Plan a shipped procedure in its quick form on that station, on START's day."""
    procedure = quick_procedure(folder, name, *changes)
    return plan_run(procedure, station, load_registry(), SimulatedClock(START))
