"""Settings with which the plugin can be tried without an instrument."""

from __future__ import annotations

from typing import Any

_ACTUAL = {"input": 1, "scale": 0.01, "unit": "Hz"}
TRIAL: dict[str, Any] = {
    "simulated": "yes",
    "simulator": "inverter",
    "identification": {"standard": "yes", "expect": {"model": "SIM-VFD"}},
    "fault": {"input": 3},
    "channels": {"frequency": _ACTUAL, "current": {"input": 2, "scale": 0.01, "unit": "A"}},
    "drives": {
        "frequency": {
            "holding": 1,
            "scale": 0.01,
            "unit": "Hz",
            "min": "0 Hz",
            "max": "35 Hz",
            "safe": "0 Hz",
            "rate": "20 Hz/s",
            "settle": "1 s",
            "read_back": _ACTUAL,
            "run": [{"holding": 0, "value": 1}],
            "stop": [{"holding": 0, "value": 0}],
            "sets_cycle_frequency": "yes",
        }
    },
}
ABSENT: dict[str, Any] = {
    "simulated": "no",
    "simulator": None,
    "tcp": {"host": "127.0.0.1", "port": 1},
}
"""Nobody listens there: the port is reserved (IANA: tcpmux)."""
