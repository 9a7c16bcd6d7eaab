"""Settings with which the plugin can be tried without an instrument."""

from __future__ import annotations

from typing import Any

TRIAL: dict[str, Any] = {
    "port": "/dev/ttyUSB0",
    "simulated": "yes",
    "termination": "CRLF",
    "channels": {"mass": {"pattern": "ST,(.*)", "unit_in_answer": "g", "unit": "g"}},
    "example": "ST,+00012.78  g",
    "rate": "10 Hz",
}
"""Of a balance that sends A&D's standard format."""
ABSENT: dict[str, Any] = {"port": "/dev/ttyNobody", "simulated": "no"}
