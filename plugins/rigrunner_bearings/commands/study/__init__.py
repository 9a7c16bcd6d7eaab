"""`rigrunner study`: how reliable Rigrunner's own statements are on simulated rigs."""

from __future__ import annotations

from rigrunner.cli.lazy import lazy_group

SUMMARIES = {
    "diagnostics": "Measure false alarms and misses of the checks.",
    "coverage": "Measure errors, and how often the stated interval holds the truth.",
    "faults": "Measure how many wrong results pass in silence, with faults put in.",
}

command = lazy_group(
    "study",
    __name__,
    SUMMARIES,
    """Validate uncertainty coverage and fault detection by simulation.

The same seed gives the same rigs and the same tables.""",
)
