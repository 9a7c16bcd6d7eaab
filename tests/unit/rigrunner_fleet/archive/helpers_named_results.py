"""Run folders with named results: a resistance over the temperature of a chamber."""

from __future__ import annotations

from typing import TYPE_CHECKING

from unit.rigrunner_fleet.archive.helpers_archive import estimate, store_run

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

LIMITS_OHM = {0.0: (99.883, 100.117), 100.0: (138.203, 138.808)}
"""IEC 60751:2022, class B."""


def resistance_document(ohms: Mapping[float, float], unit: str = "Ω", u: float = 0.005) -> dict:
    """Return a result as `result.json` has it: a resistance for each temperature in °C."""
    factor = {"Ω": 1.0, "mΩ": 1000.0}[unit]
    results, parts = [], []
    for celsius, ohm in ohms.items():
        result = estimate(ohm * factor, u * factor, unit)
        results.append(
            {
                "name": "resistance", "symbol": "R", "text": "resistance of the sensor",
                "coordinates": {"chamber.temperature": {"value": celsius, "unit": "°C"}},
                "estimate": result, "readings": 5, "budget": [],
            }
        )  # fmt: skip
        low, high = (limit * factor for limit in LIMITS_OHM[celsius])
        parts.append(
            {
                "of": "as it is called there", "named": "resistance",
                "coordinates": {"chamber.temperature": {"value": celsius, "unit": "°C"}},
                "verdict": "pass" if low <= ohm * factor <= high else "fail",
                "lower_limit": {"value": low, "unit": unit},
                "upper_limit": {"value": high, "unit": unit}, "result": result,
            }
        )  # fmt: skip
    failed = any(part["verdict"] == "fail" for part in parts)
    verdict = {"verdict": "fail" if failed else "pass", "reason": "made"}
    return {
        "format": "rigrunner: result/1",
        "measurand": {"symbol": "", "name": "", "unit": "N·m"},
        "headline": {"method": None, "compensated": None, "budget": [], "raw_peak": None},
        "results": results, "verdict": verdict, "limits": None,
        "decision": {**verdict, "rule": "simple", "limit": "made", "parts": parts},
        "checks": [], "points": [], "no_load_points": [], "compensations": {}, "fits": [],
    }  # fmt: skip


def store_resistances(
    runs: Path, name: str, ohms: Mapping[float, float], unit: str = "Ω", **header: object
) -> Path:
    """Store a run with these resistances by temperature in °C."""
    return store_run(runs, name, resistance_document(ohms, unit), recordings=0, **header)
