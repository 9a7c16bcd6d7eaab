"""A run on an instrument behind VISA that fails: a clear message, and a rig that is safe."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from helpers_devices import Listener, run
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
)
from rigrunner.api.events import Outcome
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig
from unit.rigrunner_plugins.devices.helpers_instruments import instrument, merged
from unit.rigrunner_plugins.devices.helpers_peers import HANG_UP, SILENCE, Lines, SocketPeer, peer


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
    "timeout": "1500 ms",
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
        "paced": "no",
    },
}
"""On a simulated clock: on a busy machine real blocks are so late that a gap is reported."""


class ScpiTester:
    """The instrument of TESTER; `trouble` gets each message, and may answer in its place."""

    def __init__(self, trouble=lambda _: None):
        self.trouble = trouble
        self.drives = {"FREQ": "7", "LOAD": "700"}
        self.output = True
        self.recording = False
        self.lock = threading.Lock()
        self.next = 0

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
            self.next = 0
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
        data = np.stack([0.25 + 1e-6 * numbers, -0.01 + 1e-6 * numbers], 1).astype(">f4").tobytes()
        return b"#%d%d%s\n" % (len(str(len(data))), len(data), data)


class Trouble:
    """Answers differently to `times` messages with a prefix, from the nth on."""

    def __init__(self, begins, nth, answer, times=1):
        self.begins, self.after, self.answer, self.left = begins, nth, answer, times

    def __call__(self, line):
        if not line.startswith(self.begins):
            return None
        self.after -= 1
        if self.after >= 0 or self.left == 0:
            return None
        self.left -= 1
        return self.answer(line) if callable(self.answer) else self.answer


@pytest.fixture
def tester():
    return ScpiTester()


@pytest.fixture
def bench(tester):
    with peer(SocketPeer, Lines(tester)) as server:
        yield server


@pytest.fixture
def device(bench):
    device = instrument("visa", merged(TESTER, resource=bench.resource), SimulatedClock())
    yield device
    device.close()


def alarms(listener):
    return " ".join(str(event) for event in listener.events if type(event).__name__ == "Alarm")


def test_run_without_trouble_completes(device, tester):
    summary = run(device)
    assert summary.outcome is Outcome.COMPLETED, summary.error
    assert summary.safe
    assert tester.safe


@pytest.mark.parametrize(
    ("trouble", "kind", "message"),
    [
        pytest.param(
            Trouble("FETC?", 3, SILENCE),
            DeviceTimeoutError,
            r"tester: no block in answer to 'FETC\? \d+' within 1\.\d+ s",
            id="silent while streaming",
        ),
        pytest.param(
            Trouble("FETC?", 3, HANG_UP),
            DeviceLostError,
            r"tester: no block in answer to 'FETC",
            id="unplugged while streaming",
        ),
        pytest.param(
            Trouble("SOUR:FREQ?", 1, HANG_UP),
            DeviceLostError,
            r"tester: no answer to 'SOUR:FREQ\?'",
            id="unplugged while setting",
        ),
        pytest.param(
            Trouble("SYST:ERR?", 4, b'-222,"Data out of range"\n'),
            DeviceRejectedError,
            r"tester: the instrument does not accept '.*': -222,\"Data out of range\"",
            id="an error in the queue",
        ),
        pytest.param(
            Trouble("MEAS:LOAD?", 0, b"12.0 kN\n"),
            DeviceRejectedError,
            r"after the number is 'kN', expected nothing more",
            id="another unit",
        ),
        pytest.param(
            Trouble("MEAS:LOAD?", 0, b"1000\r"),
            DeviceTimeoutError,
            r"no answer to 'MEAS:LOAD\?' within 1.5 s.*with LF, as `termination` says",
            id="another termination",
        ),
        pytest.param(
            Trouble("MEAS:LOAD?", 0, b"+9.9E37\n"),
            DeviceRejectedError,
            r"9.9e\+37: the instrument reports overload",
            id="overload",
        ),
    ],
)
def test_failure_ends_the_run_with_a_clear_message_and_a_safe_rig(
    device, tester, trouble, kind, message
):
    tester.trouble = trouble
    summary = run(device)
    assert summary.outcome is Outcome.ERROR
    assert isinstance(summary.error, kind)
    with pytest.raises(type(summary.error), match=message):
        raise summary.error
    assert summary.safe
    assert tester.safe


def test_instrument_that_stays_away_leaves_a_rig_reported_unsafe(device, bench):
    def gone(_line):
        bench.close()
        return HANG_UP

    bench._talk.answer.trouble = Trouble("FETC?", 3, gone)
    listener = Listener()
    summary = run(device, critical=[listener])
    assert summary.outcome is Outcome.ERROR
    assert not summary.safe
    assert "make safe failed" in alarms(listener)


def test_another_instrument_is_not_touched(device, tester, bench):
    tester.trouble = Trouble("*IDN?", 0, b"OTHER,PSU,1,1\n", times=99)
    before = dict(tester.drives)
    with (
        pytest.raises(DeviceNotFoundError, match="'OTHER,PSU,1,1'"),
        Rig({"tester": device}, device.clock),
    ):
        pass
    assert tester.drives == before
    assert bench._talk.heard == ["*IDN?"] * len(bench._talk.heard)
