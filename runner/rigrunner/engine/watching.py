"""One interlock: whether its condition holds, how long it may not, and since when."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api.data import Array, Mask
    from rigrunner.plan.actions import Interlock

# Sums of intervals such as 0.1 s are not exact: what lasts as long as the limit counts.
_ROUNDING_S = 1e-9


@dataclass(eq=False)
class Watch:
    """State of the channel of an interlock; times by the clock of the rig, values in SI units."""

    interlock: Interlock
    good_s: float
    """When the channel was last known to be in range; at first, the start of monitoring."""
    looked_s: float = -np.inf
    """When it was last read."""
    tripped: bool = False
    overridden: bool = False
    """Whether a person has overridden it until it clears."""
    text: str = ""
    """What was found when it last tripped or cleared."""
    latency_s: float = 0.0
    """Longest possible time before detection."""
    changes: list[Literal["tripped", "cleared"]] = field(default_factory=list)
    """Changes that were not reported yet."""
    _bad_since_s: float | None = None
    _last: tuple[float, float] | None = None

    def take(self, times_s: Array, values: Array, now_s: float) -> None:
        """Check consecutive values, each array of shape (n,), n > 0."""
        self.looked_s = now_s
        bad = self._bad(times_s, values)
        worst = float(values[int(np.argmax(bad))])
        if self._lasts(times_s, bad):
            self._trip(f"{self._value_text(worst)}, {self.interlock.condition}", now_s)
        # After tripping: the latency counts from the last good value before.
        if not bad.all():
            self.good_s = float(times_s[np.flatnonzero(~bad)[-1]])
        may_clear = self.tripped and not self.interlock.latched
        if may_clear and not bad.any() and self._is_clear(values):
            self.tripped = self.overridden = False
            self.text = f"{self._value_text(float(values[-1]))} again"
            self.changes.append("cleared")

    def miss(self, now_s: float, why: str) -> None:
        """Note that no value was available."""
        self.looked_s = now_s
        if self._bad_since_s is None:
            # It may have been bad ever since it was last seen in range.
            self._bad_since_s = self.good_s
        stale_s = self.interlock.stale_s
        allowed_s = self.interlock.debounce_s if stale_s is None else stale_s
        if now_s - self._bad_since_s >= allowed_s:
            self._trip(f"{self.interlock.member} cannot be read: {why}", now_s)

    def _bad(self, times_s: Array, values: Array) -> Mask:
        interlock = self.interlock
        # Not written as "below or above": NaN is in no range, and so is bad.
        bad = ~((values >= interlock.minimum) & (values <= interlock.maximum))
        if interlock.rate_per_s is not None:
            bad |= self._changes_too_fast(times_s, values, interlock.rate_per_s)
        return bad

    def _changes_too_fast(self, times_s: Array, values: Array, rate_per_s: float) -> Mask:
        """Return which values changed faster, by the means of parts that last for `every`.

        Over a shorter time noise would look like a change; over a longer one a jump would be lost.
        """
        too_fast = np.zeros(len(values), bool)
        shortest_s = self.interlock.every_s - _ROUNDING_S
        step_s = float(times_s[-1] - times_s[0]) / max(len(values) - 1, 1)
        count = max(int(len(values) * step_s / shortest_s), 1)
        for part in np.array_split(np.arange(len(values)), min(count, len(values))):
            middle_s, mean = float(times_s[part].mean()), float(values[part].mean())
            if self._last is not None:
                before_s, before = self._last
                passed_s = middle_s - before_s
                if passed_s < shortest_s:
                    continue
                too_fast[part] = abs(mean - before) > rate_per_s * passed_s
            self._last = (middle_s, mean)
        return too_fast

    def shift(self, began_s: float, by_s: float) -> None:
        """Move times of a stream that turns out to have begun earlier than `began_s`."""
        if self._last is not None and self._last[0] > began_s:
            self._last = (self._last[0] - by_s, self._last[1])
        if self._bad_since_s is not None and self._bad_since_s > began_s:
            self._bad_since_s -= by_s

    def _lasts(self, times_s: Array, bad: Mask) -> bool:
        """Return whether the condition held for the debounce time without interruption."""
        edges = np.diff(np.concatenate(([False], bad, [False])).astype(np.int8))
        starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
        began_s = times_s[starts]
        # A condition that lasts since an earlier block counts from its start there.
        if len(starts) and starts[0] == 0 and self._bad_since_s is not None:
            began_s[0] = self._bad_since_s
        self._bad_since_s = float(began_s[-1]) if bad[-1] else None
        return bool(np.any(times_s[ends] - began_s >= self.interlock.debounce_s - _ROUNDING_S))

    def _is_clear(self, values: Array) -> bool:
        interlock, margin = self.interlock, self.interlock.hysteresis
        low, high = interlock.minimum + margin, interlock.maximum - margin
        return bool(np.all((values >= low) & (values <= high)))

    def _trip(self, text: str, now_s: float) -> None:
        if self.tripped:
            return
        self.tripped, self.text = True, text
        self.latency_s = max(now_s - self.good_s, 0.0)
        self.changes.append("tripped")

    def _value_text(self, value: float) -> str:
        unit = self.interlock.shown
        return f"{self.interlock.member} is {(value - unit.offset) / unit.factor:.4g} {unit.symbol}"
