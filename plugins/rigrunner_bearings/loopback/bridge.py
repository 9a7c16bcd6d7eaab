"""A torque bridge with an encoder input, both on one clock, that speaks SCPI over TCP.

Program messages end in a line feed (IEEE 488.2, 7.5); samples come as definite-length blocks of
big-endian float32 (8.7.9), angle and torque in turn.
"""

from __future__ import annotations

import socketserver
import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.devices.simulated.sampling import (
    RigState,
    noise_source,
    rig_source,
    sample_channels,
)
from rigrunner_bearings.devices.simulated.sensor_errors import draw_constant_errors

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import Array
    from rigrunner_bearings.devices.simulated.sampling import SimulatedRig
    from rigrunner_plugins.devices.plant import Plant

IDENTITY = "Rigrunner,Loopback torque bridge,SIM-LB-01,1.0"
NO_ERROR = '0,"No error"'
UNDEFINED_HEADER = '-113,"Undefined header"'
ILLEGAL_PARAMETER = '-224,"Illegal parameter value"'
NO_DATA = '-230,"Data corrupt or stale"'
MEMORY_S = 64.0
"""How long one acquisition can last."""
TEMPERATURE_C = 23.0


class RefusedError(Exception):
    """A program message that the bridge does not take; its text goes to the error queue."""


@dataclass(frozen=True, eq=False)
class Acquisition:
    """Samples that come to be one after the other, at the pace of the clock."""

    samples: Array
    """Shape (n, 2): angle in degrees and torque in N·m."""
    rate_hz: float
    began_s: float

    def ready_s(self, count: int) -> float:
        """Return when that many samples have come to be, on the monotonic clock."""
        return self.began_s + count / self.rate_hz


class Bridge:
    """What the instrument does, for any connection."""

    def __init__(self, rig: SimulatedRig, plant: Plant, seed: int) -> None:
        self._rig = rig
        self._plant = plant
        self._seed = seed
        self._errors = draw_constant_errors(rig.sensors, rig_source(seed))
        self._switched_on_s = time.monotonic()
        self._recordings = 0
        self._lock = threading.Lock()

    def acquire(self, count: int) -> Acquisition:
        """Begin to record that many samples of angle and torque."""
        with self._lock:
            self._recordings += 1
            repetition = self._recordings
        elapsed_s = time.monotonic() - self._switched_on_s
        state = RigState(self._plant.frequency_hz, self._plant.load_n, elapsed_s)
        rng = noise_source(self._seed, state, repetition)
        channels = sample_channels(self._rig, state, count, self._errors, rng)
        samples = np.column_stack([np.rad2deg(channels["angle"]), channels["torque"]])
        return Acquisition(samples, self._rig.sensors.sample_rate_hz, time.monotonic())

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        return self._rig.sensors.sample_rate_hz


class _Conversation(socketserver.StreamRequestHandler):
    """One controller's connection: program messages in, response messages out."""

    server: BridgeServer

    def setup(self) -> None:
        super().setup()
        self._errors: list[str] = []
        self._acquisition: Acquisition | None = None
        self._fetched = 0
        self._answers: dict[str, Callable[[], str]] = {
            "*IDN?": lambda: IDENTITY,
            "*OPC?": lambda: "1",
            "SYST:ERR?": lambda: self._errors.pop(0) if self._errors else NO_ERROR,
            "ACQ:RATE?": lambda: f"{self._bridge.sample_rate_hz:g}",
            "MEAS:ANGL?": lambda: f"{self._bridge.acquire(1).samples[0, 0]:.4f}",
            "MEAS:TORQ?": lambda: f"{self._bridge.acquire(1).samples[0, 1]:.6f} NM",
            "MEAS:TEMP?": lambda: f"{TEMPERATURE_C:.1f}",
        }

    def handle(self) -> None:
        for line in self.rfile:
            message = line.decode("ascii", errors="replace").strip()
            try:
                answer = self._answer(message)
            except RefusedError as refused:
                self._errors.append(str(refused))
                continue
            if answer is not None:
                self.wfile.write(answer + b"\n")

    @property
    def _bridge(self) -> Bridge:
        return self.server.bridge

    def _answer(self, message: str) -> bytes | None:
        header, _, argument = message.partition(" ")
        if header in self._answers and not argument:
            return self._answers[header]().encode("ascii")
        if header == "*CLS":
            self._errors.clear()
        elif header == "INIT":
            self._acquisition = self._bridge.acquire(round(MEMORY_S * self._bridge.sample_rate_hz))
            self._fetched = 0
        elif header == "ABOR":
            self._acquisition = None
        elif header == "TRAC:DATA?":
            return self._block(argument)
        else:
            raise RefusedError(UNDEFINED_HEADER)
        return None

    def _block(self, argument: str) -> bytes:
        """Return the next samples as an IEEE 488.2 definite-length block, once they are there."""
        acquisition = self._acquisition
        if acquisition is None:
            raise RefusedError(NO_DATA)
        most = len(acquisition.samples) - self._fetched
        if not argument.isdecimal() or not 0 < int(argument) <= most:
            raise RefusedError(ILLEGAL_PARAMETER)
        until = self._fetched + int(argument)
        time.sleep(max(0.0, acquisition.ready_s(until) - time.monotonic()))
        data = acquisition.samples[self._fetched : until].astype(">f4").tobytes()
        self._fetched = until
        return f"#{len(str(len(data)))}{len(data)}".encode("ascii") + data


class BridgeServer(socketserver.ThreadingTCPServer):
    """The bridge's network socket; use it as a context manager, and `serve_forever` in a thread."""

    allow_reuse_address = True
    daemon_threads = True

    def __init__(self, bridge: Bridge, host: str = "127.0.0.1", port: int = 0) -> None:
        self.bridge = bridge
        super().__init__((host, port), _Conversation)

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self.server_address[1])
