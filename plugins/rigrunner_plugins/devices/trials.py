"""Settings with which devices can be tried without an instrument, and where no instrument is."""

from __future__ import annotations

from typing import Any

TABLE: dict[str, Any] = {
    "title": "A table of three rows",
    "set_points": ["frequency", "load"],
    "cycle_frequency": "frequency",
    "rows": [
        {"frequency": "0 Hz", "load": "0 N", "angle": "0 deg", "torque": "0 N·m"},
        {"frequency": "1 Hz", "load": "10 N", "angle": "2 deg", "torque": "1.2 N·m"},
        {"frequency": "10 Hz", "load": "100 N", "angle": "2 deg", "torque": "1.3 N·m"},
    ],
}
"""With which the table is tried."""
PARTS: dict[str, Any] = {
    "parts": {
        "rig": {"plugin": "swing_tester_sim"},
        "table": {"plugin": "tabulated", "settings": TABLE},
    },
    "channels": {"angle": "rig.angle", "torque": "rig.torque", "reference": "table.torque"},
    "drives": {"frequency": "rig.frequency", "load": "rig.load"},
}
"""With which a role of several instruments is tried."""
_ACTUAL = {"input": 1, "scale": 0.01, "unit": "Hz"}
MODBUS: dict[str, Any] = {
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
ABSENT_MODBUS: dict[str, Any] = {
    "simulated": "no",
    "simulator": None,
    "tcp": {"host": "127.0.0.1", "port": 1},
}
"""Nothing listens there: the port is reserved (IANA: tcpmux)."""
VISA: dict[str, Any] = {
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
"""An address reserved for documentation (RFC 5737)."""
ABSENT_VISA: dict[str, Any] = {"resource": NOBODY, "backend": "@py", "simulated": "no"}
SERIAL_ASCII: dict[str, Any] = {
    "port": "/dev/ttyUSB0",
    "simulated": "yes",
    "termination": "CRLF",
    "channels": {"mass": {"pattern": "ST,(.*)", "unit_in_answer": "g", "unit": "g"}},
    "example": "ST,+00012.78  g",
    "rate": "10 Hz",
}
"""Of a balance that sends A&D's standard format."""
ABSENT_SERIAL_ASCII: dict[str, Any] = {"port": "/dev/ttyNobody", "simulated": "no"}
PYMEASURE: dict[str, Any] = {
    "instrument": "pymeasure.instruments.fakes.SwissArmyFake",
    "simulated": "yes",
    "resource": "ASRL1::INSTR",
    "channels": {"voltage": {"property": "voltage", "unit": "V"}},
    "drives": {
        "output": {
            "property": "output_voltage",
            "unit": "V",
            "min": "0 V",
            "max": "5 V",
            "safe": "0 V",
        }
    },
}
"""PyMeasure's own simulated instrument."""
ABSENT_PYMEASURE: dict[str, Any] = {
    "instrument": "pymeasure.instruments.keithley.Keithley2000",
    "resource": NOBODY,
    "simulated": "no",
    "drives": {},
}
