"""A lever with weights on a turntable, and the torque transducer that it calibrates, over SCPI.

The transducer has a gain error, a cubic non-linearity, hysteresis that depends on where it came
from, a zero that creeps with each loading, and a deviation that follows its mounting position.
"""

from __future__ import annotations

from contextlib import contextmanager
from math import cos, radians
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_plugins.loopback.scpi import Bench, ScpiServer

if TYPE_CHECKING:
    from collections.abc import Iterator

HIGHEST_NM = 10.0
GAIN = 1.004
"""Indicated over applied torque at full scale."""
CUBIC = -0.002
"""Of full scale: how far the curve is off the line, by the share of full scale and its cube."""
HYSTERESIS_NM = 0.008
"""The most by which falling torque reads more than rising, at half of full scale."""
ZERO_NM = 0.004
"""To where the zero creeps in a mounting position: with each loading by half of what is left."""
POSITION_NM = 0.004
"""The amplitude of its sine over the mounting position, at full scale."""
NOISE_NM = 0.0002


class Lever:
    """Weights on a lever put a torque on the transducer."""

    def __init__(self) -> None:
        self.torque_nm = 0.0
        self.position_deg = 0.0
        self._falling = False
        self._loadings = 0

    def load(self, torque_nm: float) -> None:
        """Put on the weights for a torque; raise ValueError where there are none."""
        if not abs(torque_nm) <= HIGHEST_NM:
            raise ValueError(f"{torque_nm:g} N·m is out of range")
        if torque_nm != self.torque_nm:
            self._falling = abs(torque_nm) < abs(self.torque_nm)
        if torque_nm == 0 and self.torque_nm != 0:
            self._loadings += 1
        self.torque_nm = torque_nm

    def turn(self, position_deg: float) -> None:
        """Mount the transducer in another position, where its zero is what it was."""
        self.position_deg = position_deg
        self._loadings = 0

    @property
    def indicated_nm(self) -> float:
        """What the transducer shows, without noise."""
        share = self.torque_nm / HIGHEST_NM
        value = GAIN * self.torque_nm + CUBIC * HIGHEST_NM * (share**3 - share)
        value += POSITION_NM * share * cos(radians(self.position_deg))
        if self._falling:
            # 4 s (1 - s) is 1 at half of full scale, and 0 at both ends.
            value += 4 * HYSTERESIS_NM * share * (1 - abs(share))
        return value + ZERO_NM * (1 - 0.5**self._loadings)


@contextmanager
def running_lever(seed: int = 1) -> Iterator[Bench]:
    """Run lever and amplifier on 127.0.0.1 until the block ends; raise OSError without a port."""
    lever, noise = Lever(), np.random.default_rng([seed, 4])
    of_lever = {
        "*IDN?": lambda: "Rigrunner,Loopback lever,SIM-LV-01,1.0",
        "SOUR:TORQ?": lambda: f"{lever.torque_nm:.6f}",
        "SOUR:POS?": lambda: f"{lever.position_deg:.3f}",
    }
    of_amplifier = {
        "*IDN?": lambda: "Rigrunner,Loopback torque amplifier,SIM-TA-01,1.0",
        "MEAS:TORQ?": lambda: f"{lever.indicated_nm + noise.normal(0, NOISE_NM):.5f}",
    }
    commands = {"SOUR:TORQ": lever.load, "SOUR:POS": lever.turn}
    with ScpiServer(of_lever, commands) as lever_server, ScpiServer(of_amplifier) as amplifier:
        yield Bench("lever", {"lever": lever_server.port, "amplifier": amplifier.port})
