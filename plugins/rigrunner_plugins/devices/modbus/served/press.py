"""A press that loads the bearing, as a Modbus unit.

Its registers are this project's own:

    holding 0     control word: bit 0 press
            1-2   set-point in N, float32, low word first
    input   0-1   actual load in N, float32, low word first
            2     status word: bit 0 pressing, bit 1 at set-point
"""

from __future__ import annotations

import struct
import threading
from typing import TYPE_CHECKING

from pymodbus.constants import ExcCodes

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner_plugins.devices.plant import Plant

PRESS = 1 << 0
PRESSING, AT_SET_POINT = 1 << 0, 1 << 1
_HIGHEST_N = 3000.0
_NEAR_N = 0.5
"""How near the load is to the set-point, to count as there."""


class Press:
    """Brings the plant's load to the set-point while the control word says press."""

    identity: Mapping[int, str] = {0: "Rigrunner", 1: "SIM-PRESS", 2: "1.0"}

    def __init__(self, plant: Plant, unit_id: int = 2) -> None:
        self.unit_id = unit_id
        self._plant = plant
        self._lock = threading.Lock()
        self._words = [0, 0, 0]

    def inputs(self) -> Sequence[int]:
        """Return the actual load and the status word."""
        load_n = self._plant.load_n
        with self._lock:
            pressing = PRESSING if self._words[0] & PRESS else 0
            at_set_point = AT_SET_POINT if abs(load_n - _number(self._words[1:])) <= _NEAR_N else 0
        high, low = struct.unpack(">HH", struct.pack(">f", load_n))
        return [low, high, pressing | at_set_point]

    def holding(self) -> Sequence[int]:
        """Return control word and set-point."""
        with self._lock:
            return list(self._words)

    def written(self, address: int, words: Sequence[int]) -> ExcCodes | None:
        """Take the words; a set-point beyond its range is refused."""
        with self._lock:
            new = [*self._words[:address], *words, *self._words[address + len(words) :]]
            set_point_n = _number(new[1:])
            if not 0.0 <= set_point_n <= _HIGHEST_N:
                return ExcCodes.ILLEGAL_VALUE
            self._words = new
            self._plant.go_to_load(set_point_n if new[0] & PRESS else 0.0)
        return None

    def tick(self) -> None:
        """Do nothing: it has no watchdog."""


def _number(registers: Sequence[int]) -> float:
    low, high = registers
    return float(struct.unpack(">f", struct.pack(">HH", high, low))[0])
