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
"""Each shipped procedure: its station, and what is run before it."""


def shipped(name: str, folder: Path) -> Flat:
    """Run a shipped procedure and what it needs before; return what it found."""
    where, before = SHIPPED[name]
    for each in before:
        _run(each, where, folder)
    return _run(name, where, folder)


def faulty_rig(seed: int, folder: Path) -> Flat:
    """Run the guard's two procedures on one of its rigs; return what both found."""
    file = folder / "station.yaml"
    file.write_text(station(seed), encoding="utf-8")
    found = {}
    for name in ("no_load", "loaded"):
        one = _run(str(HERE / f"{name}.yaml"), str(file), folder)
        found |= {f"{name}: {key}": value for key, value in one.items()}
    return found


def _run(procedure: str, where: str, folder: Path) -> Flat:
    """Return the exit code and what was found; of a run that has no result the code alone."""
    runs = folder / "runs"
    known = set(runs.glob("*"))
    called = call(
        "run", procedure, "--station", where, "--runs", str(runs), "--unattended", "--json"
    )
    found: dict[str, Any] = {"exit code": int(called.code)}
    for new in set(runs.glob("*")) - known:
        result = new / "result.json"
        if result.exists():
            found |= flat(json.loads(result.read_text(encoding="utf-8")))
    return found
