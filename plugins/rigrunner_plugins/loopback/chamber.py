"""A temperature chamber and an ohmmeter, both over SCPI, with a platinum sensor between them.

The sensor follows IEC 60751:2022, 5.1, and is off by a part of its class B tolerance.
"""

from __future__ import annotations

import time
from contextlib import contextmanager
from math import exp
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_plugins.loopback.scpi import Bench, ScpiServer

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOM_C = 23.0
TIME_CONSTANT_S = 0.1
"""Of the chamber; a real one takes minutes."""
LOWEST_C, HIGHEST_C = -40.0, 150.0
R_0, A, B, C = 100.0, 3.9083e-3, -5.775e-7, -4.183e-12
"""Of a platinum sensor Pt100 (IEC 60751): R/Ω = R_0 (1 + A t + B t² + C (t - 100 °C) t³)."""
DEVIATION_K = 0.1
"""By which the sensor is off."""
NOISE_OHM = 0.002


def platinum(celsius: float) -> float:
    """Return the resistance of the nominal sensor in Ω; the last term is for t < 0 °C alone."""
    cold = C * (celsius - 100) * celsius**3 if celsius < 0 else 0.0
    return R_0 * (1 + A * celsius + B * celsius**2 + cold)


class Chamber:
    """Moves to a set temperature as a first-order system does."""

    def __init__(self) -> None:
        self._from_c = self._to_c = ROOM_C
        self._since_s = time.monotonic()

    @property
    def temperature_c(self) -> float:
        """What it is now."""
        left = exp(-(time.monotonic() - self._since_s) / TIME_CONSTANT_S)
        return self._to_c + (self._from_c - self._to_c) * left

    def go_to(self, celsius: float) -> None:
        """Begin to move; raise ValueError beyond what it can do."""
        if not LOWEST_C <= celsius <= HIGHEST_C:
            raise ValueError(f"{celsius:g} °C is out of range")
        self._from_c, self._to_c, self._since_s = self.temperature_c, celsius, time.monotonic()


@contextmanager
def running_chamber(seed: int = 1) -> Iterator[Bench]:
    """Run chamber and ohmmeter on 127.0.0.1 until the block ends; raise OSError without a port."""
    chamber, noise = Chamber(), np.random.default_rng([seed, 3])

    def resistance() -> str:
        ohm = platinum(chamber.temperature_c + DEVIATION_K) + noise.normal(0, NOISE_OHM)
        return f"{ohm:.4f}"

    of_chamber = {
        "*IDN?": lambda: "Rigrunner,Loopback chamber,SIM-CH-01,1.0",
        "SOUR:TEMP?": lambda: f"{chamber.temperature_c:.2f}",
        "MEAS:TEMP?": lambda: f"{chamber.temperature_c:.2f}",
    }
    of_meter = {
        "*IDN?": lambda: "Rigrunner,Loopback ohmmeter,SIM-OM-01,1.0",
        "MEAS:RES?": resistance,
    }
    commands = {"SOUR:TEMP": chamber.go_to}
    with ScpiServer(of_chamber, commands) as chamber_server, ScpiServer(of_meter) as meter:
        yield Bench("chamber", {"chamber": chamber_server.port, "ohmmeter": meter.port})
