"""A bearing under test that wears and warms with the cycles since it was mounted."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner_bearings.devices.simulated.sampling import SimulatedRig

LOAD_N, FREQUENCY_HZ = 1000.0, 10.0
"""Load and frequency at which the warming is stated; it is proportional to both."""
STEP = 500
"""The rig changes with whole steps of so many cycles: what it computes can be remembered."""


@dataclass
class Specimen:
    """Counts the cycles under load, and follows the temperature."""

    rig_after: Callable[[float], SimulatedRig]
    """Gives the rig after so many cycles under load."""
    warming_k: float
    """The final rise of temperature in K, at LOAD_N and FREQUENCY_HZ."""
    warming_time_s: float
    """The time constant: after it, 63 % of a change of temperature has occurred."""
    cycles: float = 0.0
    rise_k: float = 0.0
    _until_s: float | None = None

    def renew(self) -> None:
        """Mount a new one, at the temperature of the room."""
        self.cycles, self.rise_k, self._until_s = 0.0, 0.0, None

    def wear(self, now_s: float, frequency_hz: float, load_n: float) -> None:
        """Add the time since the last call, with the drives at these values."""
        passed_s = 0.0 if self._until_s is None else now_s - self._until_s
        self._until_s = now_s
        if load_n > 0:
            self.cycles += frequency_hz * passed_s
        end_k = self.warming_k * (load_n / LOAD_N) * (frequency_hz / FREQUENCY_HZ)
        self.rise_k = end_k + (self.rise_k - end_k) * exp(-passed_s / self.warming_time_s)

    @property
    def rig(self) -> SimulatedRig:
        """The rig with the specimen as it is now."""
        return self.rig_after(self.cycles // STEP * STEP)
