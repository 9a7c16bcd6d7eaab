"""The torque of a recording: less its zero reading, and corrected where the register states it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.blocks import less, limits
from rigrunner_bearings.torque.channels import finite

if TYPE_CHECKING:
    from rigrunner.api import Array, Instrument, Recording, RunData
    from rigrunner.api.data import Samples


def torque_reading(recording: Recording, name: str, run: RunData) -> Samples:
    """Return the torque of a channel in N·m; raise DataError where a sample is not a number.

    With `interpolation` in the register, the deviation that its calibration points show at the
    reading is taken off, on straight lines between them; beyond the last it stays what it is there.
    """
    torque = less(finite(recording, name), run.zero(recording.name, name))
    instrument = run.instruments.get(name)
    if instrument is None or instrument.interpolation is None:
        return torque
    corrected = _Corrected(torque, instrument)
    return corrected[:] if isinstance(torque, np.ndarray) else corrected


@dataclass(frozen=True, eq=False)
class _Corrected:
    """Samples less the deviation at each, taken off as they are read."""

    values: Samples
    instrument: Instrument

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, which: slice, /) -> Array:
        return self.instrument.corrected(np.asarray(self.values[which]))

    def __array__(self, dtype: object = None, *, copy: bool | None = None) -> Array:
        return self[:]

    @property
    def limits(self) -> tuple[float, float]:
        """Return the least and the greatest: what is indicated rises with what is applied."""
        least, greatest = self.instrument.corrected(np.array(limits(self.values)))
        return float(least), float(greatest)
