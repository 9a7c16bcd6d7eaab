"""Readings that are not numbers: a text, a yes or no, an array; and their limits."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal

from rigrunner.api.verdict import LimitDecision, Limits, Verdict

Reading = bool | str | tuple[float, ...]
"""An array is a tuple of finite numbers, in the SI unit of its ReadingInfo."""
ReadingKind = Literal["text", "boolean", "array"]
_SHOWN = 4


def reading_text(value: Reading) -> str:
    """Return a reading as text: 'V1.2', 'yes', '1, 2, 3, 4, ... (512 values)'."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    numbers = ", ".join(f"{number:.6g}" for number in value[:_SHOWN])
    return numbers if len(value) <= _SHOWN else f"{numbers}, ... ({len(value)} values)"


@dataclass(frozen=True)
class OneOf(Limits):
    """The accepted values of a text, or of a yes or no."""

    allowed: tuple[str, ...] = ()

    @property
    def in_words(self) -> str:
        """The accepted values in English: 'V1.2 or V1.3'."""
        return " or ".join(self.allowed)

    @property
    def in_signs(self) -> str:
        """The same, for pages in any language."""
        return " / ".join(self.allowed)

    def __str__(self) -> str:
        """Return the accepted values as text."""
        return self.in_words


@dataclass(frozen=True)
class ReadingLimit:
    """The limit that a step sets for a text, or a yes or no."""

    of: str
    """The channel, 'role.name'."""
    allowed: tuple[bool | str, ...]
    """At least one; of one type."""

    @property
    def limits(self) -> OneOf:
        """The limits as text."""
        return OneOf(-inf, inf, "", allowed=tuple(map(reading_text, self.allowed)))

    def decision(self, value: Reading) -> LimitDecision:
        """Return the decision on a reading: whether it is one of the accepted values."""
        limits = self.limits
        verdict = Verdict.PASS if value in self.allowed else Verdict.FAIL
        return LimitDecision(
            of=self.of,
            verdict=verdict,
            reason=f"{self.of} is {reading_text(value)}, expected {limits.in_words}",
            limits=limits,
            source="the procedure",
            uncompensated=verdict,
        )
