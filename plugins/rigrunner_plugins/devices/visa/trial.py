"""Settings with which the plugin can be tried without an instrument."""

from __future__ import annotations

from typing import Any

TRIAL: dict[str, Any] = {
    "resource": "ASRL1::INSTR",
    "backend": "@sim",
    "simulated": "yes",
    "termination": "LF",
    "write_termination": "CRLF",
    "identification": {"query": "?IDN", "expect": "LSG Serial #.*"},
    "acknowledge": "OK",
    "channels": {"level": {"query": "?AMP", "unit": "V"}},
    "drives": {
        "level": {
            "command": "!AMP {value:.2f}",
            "read_back": "?AMP",
            "unit": "V",
            "min": "0 V",
            "max": "10 V",
            "safe": "0 V",
        }
    },
}
"""Of the generator that pyvisa-sim simulates by itself."""
NOBODY = "TCPIP::192.0.2.1::5025::SOCKET"
"""An address that documents use and nobody has (RFC 5737)."""
ABSENT: dict[str, Any] = {"resource": NOBODY, "backend": "@py", "simulated": "no"}
