"""The digest that identifies the measured data."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.data import Array


class RecordingDigest:
    """SHA-256 over one recording, block by block.

    It covers name, rate, set-points, coordinates, units and samples.

    It is the digest of a JSON text (keys sorted, no spaces) with the digest of each channel's
    samples as little-endian float64, so that it can be checked without this program.
    """

    def __init__(
        self,
        name: str,
        rate_hz: float,
        setpoints: Mapping[str, float],
        units: Mapping[str, str],
        coordinates: Mapping[str, Coordinate],
    ) -> None:
        self._document: dict[str, object] = {
            "name": name,
            "rate_hz": float(rate_hz),
            # As floats: 1 and 1.0 are one set-point, but not one text.
            "setpoints": {key: float(value) for key, value in setpoints.items()},
            "units": dict(units),
        }
        if coordinates:  # a recording of before has none, and the same digest as before
            self._document["coordinates"] = dict(coordinates)
        self._channels: dict[str, hashlib._Hash] = {}

    def update(self, channels: Mapping[str, Array]) -> None:
        """Add further samples of every channel."""
        for channel, values in channels.items():
            digest = self._channels.setdefault(channel, hashlib.sha256())
            digest.update(np.ascontiguousarray(values, "<f8").data)

    def hexdigest(self) -> str:
        """Return the digest of all samples so far."""
        channels = {channel: digest.hexdigest() for channel, digest in self._channels.items()}
        text = json.dumps(
            {**self._document, "channels": channels}, sort_keys=True, separators=(",", ":")
        )
        return hashlib.sha256(text.encode()).hexdigest()


def lines_of(digests: Iterable[str]) -> str:
    """Return digests as text, one a line."""
    return "".join(f"{digest}\n" for digest in digests)


def run_digest(recordings: Iterable[str], rows: str) -> str:
    """Return the SHA-256 over the digests of recordings, then over the lines of measurements."""
    return hashlib.sha256((lines_of(recordings) + rows).encode()).hexdigest()
