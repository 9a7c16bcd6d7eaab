"""The runs of the guard, by the command line alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from guard.numbers import flat
from guard.rigs import station
from helpers_cli import call

if TYPE_CHECKING:
    from guard.numbers import Flat

HERE = Path(__file__).parent
RECORDED = HERE / "recorded.json"
SHIPPED = {
    "no_load_inertia_sweep": ("simulated", []),
    "starting_torque_1000n": ("simulated", ["no_load_inertia_sweep"]),
    "gauge_rr": ("simulated", ["no_load_inertia_sweep"]),
    "support_friction": ("simulated", []),
    "no_load_breakaway": ("simulated_bench", []),
    "paper_reproduction": ("paper", []),
}
"""Each shipped procedure: its station, and the procedures to run before it."""


def shipped(name: str, folder: Path) -> Flat:
    """Run a shipped procedure after those that it needs; return its numbers."""
    station_name, before = SHIPPED[name]
    for needed in before:
        _run(needed, station_name, folder)
    return _run(name, station_name, folder)


def faulty_rig(seed: int, folder: Path) -> Flat:
    """Run the guard's two procedures on one of its rigs; return the numbers of both."""
    file = folder / "station.yaml"
    file.write_text(station(seed), encoding="utf-8")
    numbers = {}
    for name in ("no_load", "loaded"):
        run_numbers = _run(str(HERE / f"{name}.yaml"), str(file), folder)
        numbers |= {f"{name}: {key}": value for key, value in run_numbers.items()}
    return numbers


def _run(procedure: str, station_name: str, folder: Path) -> Flat:
    """Return the exit code and the numbers; without a result only the exit code."""
    runs = folder / "runs"
    known_runs = set(runs.glob("*"))
    output = call(
        "run", procedure, "--station", station_name, "--runs", str(runs), "--unattended", "--json"
    )
    numbers: dict[str, Any] = {"exit code": int(output.code)}
    for run in set(runs.glob("*")) - known_runs:
        result = run / "result.json"
        if result.exists():
            numbers |= flat(json.loads(result.read_text(encoding="utf-8")))
    return numbers
