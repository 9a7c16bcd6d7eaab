"""Follows, while both stream, how another part's clock goes against the reference's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner_plugins.devices.composite.clocks.common_signal import coarse_lag, fine_lag
from rigrunner_plugins.devices.composite.clocks.relation import (
    Relation,
    Sighting,
    by_arrivals,
    line_through,
)

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_plugins.devices.composite.clocks.feed import Feed

WINDOW_S = 0.25
"""Over which the common signal is compared once."""
SURE = 4.0
"""In standard uncertainties of the arrivals: where the common signal is looked for."""
BETWEEN = 0.01
"""Of a sample: as a standard uncertainty, what comparing and interpolating samples errs by."""
_LEAST = 1e-3
"""Of a sample: the least uncertainty of one comparison, however free of noise the signal is."""
NEAR_S = 0.5e-3
"""How far from the last sighting the next one may be: more than clocks drift in a window."""


class Tracker:
    """The relation of one clock to the reference's, by all that has come so far."""

    def __init__(
        self, reference: Feed, other: Feed, common: tuple[str, str] | None, latency_s: float
    ) -> None:
        self._reference = reference
        self._other = other
        self._common = common
        self._latency_s = latency_s
        self._sightings: list[Sighting] = []
        self._compared = 0
        self._used: list[tuple[Array, Array]] = []

    def relation(self) -> Relation:
        """Return the relation; by the common signal once it was seen, or else by arrival times."""
        arrivals = by_arrivals(self._reference.arrivals, self._other.arrivals, self._latency_s)
        if self._common is not None:
            self._compare_windows(arrivals)
        return line_through(self._sightings) if self._sightings else arrivals

    def note_used(self, tau_s: Array, delta_s: Array) -> None:
        """Take note of what samples were aligned by, both of shape (n,)."""
        self._used.append((tau_s, delta_s))

    def residual_u_s(self) -> float:
        """Return how well the used samples are aligned, by all that is known at the end.

        A standard uncertainty in s: of the relation, and what it was otherwise while samples were
        handed out already.
        """
        last = self.relation()
        tau = np.concatenate([tau for tau, _ in self._used])
        residuals = np.concatenate([delta for _, delta in self._used]) - last.delta_s(tau)
        between_s = BETWEEN / min(self._reference.rate_hz, self._other.rate_hz)
        return float(np.linalg.norm([np.sqrt(np.mean(residuals**2)), last.u_s(tau), between_s]))

    def _compare_windows(self, arrivals: Relation) -> None:
        """Compare the common signal in each window that is complete in both streams."""
        rate = self._reference.rate_hz
        size = round(WINDOW_S * rate)
        while (end := self._compared + size) <= self._reference.samples:
            begin = self._compared
            range_s = SURE * arrivals.u_offset_s + 2 / self._other.rate_hz
            if self._sightings:
                range_s = NEAR_S
            estimate = line_through(self._sightings) if self._sightings else arrivals
            middle_s = (begin + size / 2) / rate
            at_s = begin / rate + float(estimate.delta_s(np.array([middle_s]))[0])
            # Beyond the range of the search, what `fine_lag` interpolates from, and some samples
            # to spare.
            first = int(np.floor((at_s - range_s) * self._other.rate_hz)) - 5
            last = int(np.ceil((at_s + range_s + size / rate) * self._other.rate_hz)) + 8
            if last > self._other.samples:
                return
            self._compared = end
            # Before the other stream began there is nothing to compare with.
            if first >= 0:
                self._compare(begin, size, first, last)

    def _compare(self, begin: int, size: int, first: int, last: int) -> None:
        assert self._common is not None  # noqa: S101  (looked for only where there is one)
        reference_channel, other_channel = self._common
        window = self._reference.channel(reference_channel, begin, begin + size)
        other = self._other.channel(other_channel, first, last)
        rate, other_rate = self._reference.rate_hz, self._other.rate_hz
        start = coarse_lag(window, other, other_rate / rate)
        lag = None if start is None else fine_lag(window, other, other_rate / rate, start)
        if lag is not None:
            tau_s, lag_s = begin / rate, (first + lag.samples) / other_rate
            middle_s = tau_s + size / rate / 2
            u_s = max(lag.u_samples, _LEAST) / other_rate
            self._sightings.append(Sighting(middle_s, lag_s - tau_s, u_s))
