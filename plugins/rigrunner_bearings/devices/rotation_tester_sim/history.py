"""What a bearing has been through on the bench: how far it turned, and how long it has rested."""

from __future__ import annotations


class History:
    """Turns since the bearing was new, and when it last moved, by the clock that is told."""

    def __init__(self, now_s: float) -> None:
        self._turns = 0.0
        self._since_s = now_s
        self._frequency_hz = 0.0

    def turns(self, now_s: float) -> float:
        """Return the turns made until now."""
        return self._turns + self._frequency_hz * (now_s - self._since_s)

    def rest_s(self, now_s: float) -> float:
        """Return how long the bearing has been at rest; 0 while it turns."""
        return 0.0 if self._frequency_hz else now_s - self._since_s

    def change(self, now_s: float, frequency_hz: float) -> None:
        """From now on the bearing turns so fast; 0: it rests."""
        if frequency_hz == self._frequency_hz:
            return
        self._turns = self.turns(now_s)
        self._since_s, self._frequency_hz = now_s, frequency_hz

    def moved(self, until_s: float, turns: float) -> None:
        """Add a start that was over at that time."""
        self._turns += turns
        self._since_s = until_s
