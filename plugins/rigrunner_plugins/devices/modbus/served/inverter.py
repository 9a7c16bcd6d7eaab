"""A frequency inverter for the swing motor, as a Modbus unit.

Its register map is made up, in the style of common inverters:

    holding 0  control word: bit 0 run, bit 7 fault reset
            1  set-point in 0.01 Hz
            2  heartbeat: any write resets the watchdog
            3  watchdog in 0.1 s; 0: off
    input   0  status word: bit 0 ready, 1 running, 2 at set-point, 3 fault
            1  actual frequency in 0.01 Hz
            2  motor current in 0.01 A
            3  fault: 0 none, 7 overload (set by `trip`), 81 communication timeout (watchdog)
"""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from pymodbus.constants import ExcCodes

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigrunner_plugins.devices.plant import Plant

CONTROL, SET_POINT, HEARTBEAT, WATCHDOG = range(4)
RUN, RESET = 1 << 0, 1 << 7
READY, RUNNING, AT_SET_POINT, FAULT = (1 << bit for bit in range(4))
OVERLOAD, TIMEOUT = 7, 81
_STEP_HZ = 0.01
_HIGHEST = 5000
"""In steps: 50 Hz."""
_IDLE_A, _AMPERE_PER_HZ = 0.4, 0.05


class Inverter:
    """Drives the motor of the plant at the set-point while the control word has its run bit."""

    identity: Mapping[int, str] = {0: "Rigrunner", 1: "SIM-VFD", 2: "1.0"}

    def __init__(
        self,
        plant: Plant,
        unit_id: int = 1,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.unit_id = unit_id
        self._plant = plant
        self._now_s = now_s
        self._lock = threading.Lock()
        self._words = [0, 0, 0, 0]
        self._fault = 0
        self._heard_s = now_s()

    def trip(self, fault: int = OVERLOAD) -> None:
        """Set a fault: the motor stops."""
        with self._lock:
            self._trip(fault)

    def inputs(self) -> Sequence[int]:
        """Return status word, actual frequency, current and fault."""
        frequency_hz = self._plant.frequency_hz
        current_a = _IDLE_A + _AMPERE_PER_HZ * frequency_hz if frequency_hz else 0.0
        with self._lock:
            actual = round(frequency_hz / _STEP_HZ)
            status = FAULT if self._fault else READY
            if self._words[CONTROL] & RUN:
                status |= RUNNING
                if actual == self._words[SET_POINT]:
                    status |= AT_SET_POINT
            return [status, actual, round(current_a / 0.01), self._fault]

    def holding(self) -> Sequence[int]:
        """Return control word, set-point, heartbeat and watchdog."""
        with self._lock:
            return list(self._words)

    def written(self, address: int, words: Sequence[int]) -> ExcCodes | None:
        """Write registers; return ILLEGAL_VALUE for a set-point above the highest."""
        new = dict(enumerate(words, address))
        with self._lock:
            if new.get(SET_POINT, 0) > _HIGHEST:
                return ExcCodes.ILLEGAL_VALUE
            self._heard_s = self._now_s()
            for place, word in new.items():
                self._words[place] = word
            if self._words[CONTROL] & RESET:
                self._fault = 0
            self._drive()
        return None

    def tick(self) -> None:
        """Trip if the watchdog is on and has expired."""
        with self._lock:
            patience_s = 0.1 * self._words[WATCHDOG]
            silent_s = self._now_s() - self._heard_s
            if patience_s and silent_s > patience_s and self._words[CONTROL] & RUN:
                self._trip(TIMEOUT)

    def _trip(self, fault: int) -> None:
        self._fault = fault
        self._words[CONTROL] &= ~RUN
        self._drive()

    def _drive(self) -> None:
        runs = self._words[CONTROL] & RUN and not self._fault
        self._plant.go_to_frequency(self._words[SET_POINT] * _STEP_HZ if runs else 0.0)
