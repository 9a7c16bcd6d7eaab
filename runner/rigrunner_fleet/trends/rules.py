"""Rules by which a control chart signals a change.

Nelson, The Shewhart Control Chart - Tests for Special Causes, J. Qual. Technol. 16 (1984) 237-239;
Western Electric, Statistical Quality Control Handbook (1956), zone rules.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import numpy.typing as npt

    _Test = Callable[[npt.NDArray[np.float64]], npt.NDArray[np.bool_]]


@dataclass(frozen=True)
class Rule:
    """A named rule; `test` maps z, shape (n,), to where it is met, shape (n,)."""

    name: str
    text: str
    test: _Test


@dataclass(frozen=True)
class Signal:
    """A rule that is met, and the index of the value, from 0."""

    rule: Rule
    index: int


def signals(values: Sequence[float], centre: float, sigma: float, rules: str) -> list[Signal]:
    """Return where rules of a set are met, in the order of the values, shape (n,).

    `rules` is a key of `RULES`. Raises KeyError for an unknown set.
    """
    z = (np.asarray(values, dtype=np.float64) - centre) / sigma
    met = [(rule, rule.test(z)) for rule in RULES[rules]]
    return [Signal(rule, index) for index in range(z.size) for rule, at in met if at[index]]


def _window(met: npt.NDArray[np.bool_], least: int, of: int) -> npt.NDArray[np.bool_]:
    """Return where at least this many of the last `of` meet the condition, including the last.

    Of the first values, where at least this many do: what comes next cannot undo that.
    """
    counts = np.cumsum(met, dtype=np.int64)
    before = np.concatenate([np.zeros(of, dtype=np.int64), counts])[: met.size]
    result: npt.NDArray[np.bool_] = met & (counts - before >= least)
    return result


def _same_side(beyond: float, least: int, of: int) -> _Test:
    def test(z: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        return _window(z > beyond, least, of) | _window(z < -beyond, least, of)

    return test


def _beyond(z: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    return np.abs(z) > 3.0  # noqa: PLR2004  (three standard deviations: Shewhart's)


def _trend(z: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    step = np.sign(np.diff(z, prepend=z[:1]))
    # Six values make five steps.
    return _window(step > 0, 5, 5) | _window(step < 0, 5, 5)


def _alternating(z: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    step = np.sign(np.diff(z, prepend=z[:1]))
    turns = np.concatenate([np.zeros(min(z.size, 1), dtype=np.bool_), step[1:] * step[:-1] < 0])
    # Fourteen values make thirteen steps, and twelve turns between them.
    return _window(turns, 12, 12)


def _within_one(z: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    return _window(np.abs(z) < 1.0, 15, 15)


def _outside_one(z: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    return _window(np.abs(z) > 1.0, 8, 8)


NELSON = (
    Rule("Nelson 1", "one value beyond 3 standard deviations", _beyond),
    Rule("Nelson 2", "nine in a row on the same side of the centre", _same_side(0.0, 9, 9)),
    Rule("Nelson 3", "six in a row that rise, or that fall", _trend),
    Rule("Nelson 4", "fourteen in a row that alternate up and down", _alternating),
    Rule("Nelson 5", "two of three beyond 2 standard deviations on one side", _same_side(2, 2, 3)),
    Rule("Nelson 6", "four of five beyond 1 standard deviation on one side", _same_side(1, 4, 5)),
    Rule("Nelson 7", "fifteen in a row within 1 standard deviation", _within_one),
    Rule("Nelson 8", "eight in a row beyond 1 standard deviation, on either side", _outside_one),
)
WESTERN_ELECTRIC = (
    Rule("Western Electric 1", "one value beyond 3 standard deviations", _beyond),
    Rule(
        "Western Electric 2",
        "two of three beyond 2 standard deviations on one side",
        _same_side(2, 2, 3),
    ),
    Rule(
        "Western Electric 3",
        "four of five beyond 1 standard deviation on one side",
        _same_side(1, 4, 5),
    ),
    Rule(
        "Western Electric 4", "eight in a row on the same side of the centre", _same_side(0, 8, 8)
    ),
)
RULES: Mapping[str, tuple[Rule, ...]] = {
    "nelson": NELSON,
    "western-electric": WESTERN_ELECTRIC,
    "shewhart": NELSON[:1],
}
"""Sets of rules by name."""
