"""What an instrument's readings may be off by, as the register has it, and what that does."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.data import Array, RunData
    from rigrunner.api.instruments import OtherInstrument, TorqueInstrument

GAIN, OFFSET, ANY = "gain", "offset", "any"
TO_STANDARD = 1 / sqrt(3)
"""From the half-width of a rectangular distribution to its standard deviation (GUM 4.3.7)."""


@dataclass(frozen=True)
class ReadingError:
    """Of what kind an error is, and how large it may be: half the width of a rectangle."""

    name: str
    kind: str
    """`gain`: one and the same share of every reading. `offset`: one and the same of all readings.
    `any`: within the half-width at each reading, and what two readings share of it is not known."""
    half_width: float
    """In the SI unit; of a gain a share."""


def reading_errors(run: RunData, channel: str, values: Array) -> Iterator[ReadingError]:
    """Yield the errors of the readings of a channel; nan of one that the register does not know."""
    torque = run.instruments.get(channel)
    if torque is not None:
        yield from _of_torque(torque, zeroed=channel in run.zeros)
        return
    other = next((each for each in run.other_instruments if each.channel == channel), None)
    yield _of_other(other, channel, values)


def _of_other(known: OtherInstrument | None, channel: str, values: Array) -> ReadingError:
    largest = float(np.abs(values).max())
    limit = None if known is None else known.limit_of_error(largest)
    name = f"reading of {channel}"
    return ReadingError(name, ANY, nan if limit is None else limit)


def _of_torque(known: TorqueInstrument, *, zeroed: bool) -> Iterator[ReadingError]:
    accuracy, name = known.accuracy, known.channel
    if accuracy.of_full_scale:
        width = accuracy.of_full_scale * known.full_scale
        yield ReadingError(f"reading of {name}", ANY, width)
        return
    yield ReadingError(f"gain of {name}", GAIN, accuracy.gain)
    if not zeroed:
        yield ReadingError(f"offset of {name}", OFFSET, accuracy.offset)
    yield ReadingError(f"drift of {name}", ANY, accuracy.drift)
    yield ReadingError(f"nonlinearity of {name}", ANY, accuracy.nonlinearity * known.full_scale)
