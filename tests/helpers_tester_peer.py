"""A tester that talks SCPI: two drives, and angle and torque recorded on one clock."""

from __future__ import annotations

import threading
import time

import numpy as np

from helpers_peers import SILENCE

RATE_HZ = 1000


def _drive(name, unit, largest):
    return {
        "command": f"SOUR:{name} {{value}}",
        "read_back": f"SOUR:{name}?",
        "unit": unit,
        "min": f"0 {unit}",
        "max": f"{largest} {unit}",
        "safe": f"0 {unit}",
        "settle": "0.5 s",
    }


TESTER = {
    "termination": "LF",
    "timeout": "500 ms",
    "identification": {"expect": "ACME,.*"},
    "error_queue": {},
    "channels": {
        "angle": {"query": "MEAS:ANGL?", "unit": "rad"},
        "torque": {"query": "MEAS:TORQ?", "unit": "N·m", "unit_in_answer": "Nm"},
        "load": {"query": "MEAS:LOAD?", "unit": "N"},
    },
    "drives": {
        "frequency": {**_drive("FREQ", "Hz", 35), "sets_cycle_frequency": "yes"},
        "load": _drive("LOAD", "N", 3000),
    },
    "safe_commands": ["OUTP OFF"],
    "stream": {
        "rate": "1 kHz",
        "channels": ["angle", "torque"],
        "start": "INIT",
        "stop": "ABOR",
        "fetch": "FETC? {samples}",
        "format": "float32",
        "byte_order": "big",
        "samples": 100,
    },
}


class ScpiTester:
    """What TESTER talks to; `trouble` is told each message, and may answer in its place."""

    def __init__(self, trouble=lambda _: None):
        self.trouble = trouble
        self.drives = {"FREQ": "7", "LOAD": "700"}
        self.output = True
        self.recording = False
        self.lock = threading.Lock()
        self.next, self.started_s = 0, 0.0

    @property
    def safe(self):
        return self.drives == {"FREQ": "0", "LOAD": "0"} and not (self.output or self.recording)

    def __call__(self, line):
        with self.lock:
            answer = self.trouble(line)
            return answer if answer is not None else self._answer(line)

    def _answer(self, line):
        head, _, value = line.partition(" ")
        name = head.rstrip("?").split(":")[-1]
        if head.startswith("SOUR:") and not head.endswith("?"):
            self.drives[name] = value
        elif head in {"INIT", "ABOR"}:
            self.recording = head == "INIT"
            self.next, self.started_s = 0, time.monotonic()
        elif head == "OUTP":
            self.output = value == "ON"
        elif head == "FETC?":
            return self._block(int(value))
        texts = {
            "*IDN?": "ACME,TESTER,12,1.0",
            "SYST:ERR?": '0,"No error"',
            "MEAS:ANGL?": "0.25",
            "MEAS:TORQ?": "-0.01 Nm",
            "MEAS:LOAD?": self.drives["LOAD"],
            "SOUR:FREQ?": self.drives["FREQ"],
            "SOUR:LOAD?": self.drives["LOAD"],
        }
        return f"{texts[head]}\n".encode() if head in texts else SILENCE

    def _block(self, count):
        numbers = np.arange(self.next, self.next + count)
        self.next += count
        time.sleep(max(0.0, self.started_s + self.next / RATE_HZ - time.monotonic()))
        data = np.stack([0.25 + 1e-6 * numbers, -0.01 + 1e-6 * numbers], 1).astype(">f4").tobytes()
        return b"#%d%d%s\n" % (len(str(len(data))), len(data), data)
