"""Compare a golden run with its result by new software."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import inf
from typing import TYPE_CHECKING

from rigrunner_fleet.golden.figures import HEADLINE

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner_fleet.golden.figures import Figure
    from rigrunner_fleet.golden.reference import Snapshot

TOLERANCE = 1e-6
"""As a fraction of U: rounding of other processors is less, a change of the software is more."""


class Standing(StrEnum):
    """How a run compares with its reference, the most serious first."""

    NOT_COMPARED = "not compared"
    VERDICT = "verdict flipped"
    REFUSED = "newly refused"
    ACCEPTED = "newly accepted"
    BEYOND = "moved beyond the tolerance"
    CHECKS = "a check came out otherwise"
    WITHIN = "moved within the tolerance"
    OTHER = "numbers equal, something else in the result differs"
    EQUAL = "equal bit for bit"

    @property
    def moved(self) -> bool:
        """Whether a person has to check it."""
        return self not in {Standing.WITHIN, Standing.OTHER, Standing.EQUAL}


MOST_SEVERE_FIRST = tuple(Standing)


@dataclass(frozen=True, kw_only=True)
class Move:
    """A figure that changed."""

    name: str
    before: Figure | None
    """None for a new figure."""
    after: Figure | None
    """None for a figure that is gone."""

    @property
    def shift(self) -> float | None:
        """The change, in the figure's unit."""
        if self.before is None or self.after is None:
            return None
        return self.after.value - self.before.value

    @property
    def in_u(self) -> float | None:
        """The change, in expanded uncertainties of the reference; None if that has none."""
        u, _ = self._expanded
        return None if self.shift is None or not u else self.shift / u

    @property
    def of_u(self) -> float | None:
        """The change of the expanded uncertainty, as a fraction of the reference's."""
        before, after = self._expanded
        return None if not before or after is None else after / before - 1

    @property
    def size(self) -> float:
        """The larger of both, without sign; infinite if it is unknown."""
        ratios = [ratio for ratio in (self.in_u, self.of_u) if ratio is not None]
        same_unit = self.before and self.after and self.before.unit == self.after.unit
        lacks_u = self.in_u is None and self.shift != 0
        before, after = self._expanded
        if not same_unit or lacks_u or (self.of_u is None and before != after):
            return inf
        return max(map(abs, ratios), default=0.0)

    @property
    def _expanded(self) -> tuple[float | None, float | None]:
        """The expanded uncertainty before and after."""
        before = self.before.expanded if self.before else None
        return before, self.after.expanded if self.after else None


@dataclass(frozen=True)
class Flips:
    """Verdicts and checks that changed, as text."""

    verdicts: tuple[str, ...] = ()
    checks: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A golden run, and the outcome of its check."""

    name: str
    before: Snapshot
    after: Snapshot
    standing: Standing
    moves: tuple[Move, ...] = ()
    """The changed figures, the largest change first."""
    flips: Flips = Flips()
    problem: str = ""
    """Why it was not compared, or is refused now."""

    @property
    def headline(self) -> Move | None:
        """The change of the result, if any."""
        return next((move for move in self.moves if move.name == HEADLINE), None)

    @property
    def largest(self) -> float:
        """The largest change of a figure, in U; 0 if none changed."""
        return max((move.size for move in self.moves), default=0.0)


def compare(
    name: str, before: Snapshot, after: Snapshot, tolerance: float = TOLERANCE
) -> Comparison:
    """Compare a result with the reference; `tolerance` is in U."""
    moves = sorted(_moves(before, after), key=lambda move: (-move.size, move.name != HEADLINE))
    flips = Flips(tuple(_verdict_flips(before, after)), tuple(_check_flips(before, after)))
    return Comparison(
        name=name,
        before=before,
        after=after,
        standing=_standing(before, after, flips, moves, tolerance),
        moves=tuple(moves),
        flips=flips,
        problem=after.problem,
    )


def not_compared(name: str, before: Snapshot, after: Snapshot, problem: str) -> Comparison:
    """Return a run that could not be compared, with the reason."""
    standing = Standing.NOT_COMPARED
    return Comparison(name=name, before=before, after=after, standing=standing, problem=problem)


def by_severity(comparison: Comparison) -> tuple[int, float, str]:
    """Return the sort key of runs: the most serious first."""
    return MOST_SEVERE_FIRST.index(comparison.standing), -comparison.largest, comparison.name


def _standing(
    before: Snapshot,
    after: Snapshot,
    flips: Flips,
    moves: list[Move],
    tolerance: float,
) -> Standing:
    had, has = _has_result(before), _has_result(after)
    applies = {
        Standing.REFUSED: bool(after.problem and not before.problem) or (had and not has),
        Standing.ACCEPTED: bool(before.problem and not after.problem) or (has and not had),
        Standing.VERDICT: bool(flips.verdicts),
        Standing.BEYOND: any(move.size > tolerance for move in moves),
        Standing.CHECKS: bool(flips.checks),
        Standing.WITHIN: bool(moves),
        Standing.EQUAL: after == before,
    }
    return next((standing for standing, met in applies.items() if met), Standing.OTHER)


def _has_result(snapshot: Snapshot) -> bool:
    return HEADLINE in snapshot.figures or bool(snapshot.results)


def _moves(before: Snapshot, after: Snapshot) -> Iterator[Move]:
    if after.problem or before.problem:
        return
    shown_as_result = f"{after.method}: torque" if after.method == before.method else None
    for name in _common(before, after, {**before.figures, **after.figures}):
        then, now = before.figures.get(name), after.figures.get(name)
        # The torque by the primary method is the result itself, compared as that.
        twice = shown_as_result is not None and name.startswith(shown_as_result)
        if then != now and not twice:
            yield Move(name=name, before=then, after=now)


def _verdict_flips(before: Snapshot, after: Snapshot) -> Iterator[str]:
    for name in {**before.verdicts, **after.verdicts}:
        then, now = (snapshot.verdicts.get(name, "no verdict") for snapshot in (before, after))
        if then != now:
            subject = "verdict" if name == "run" else f"verdict on {name}"
            yield f"{subject}: {then} -> {now}"


def _check_flips(before: Snapshot, after: Snapshot) -> Iterator[str]:
    if before.problem or after.problem:
        return
    words = {True: "passed", False: "not passed", None: "not made"}
    for name in _common(before, after, {**before.checks, **after.checks}):
        then, now = before.checks.get(name), after.checks.get(name)
        if then != now:
            yield f"check '{name}': {words[then]} -> {words[now]}"


def _common(before: Snapshot, after: Snapshot, names: Iterable[str]) -> Iterator[str]:
    """Yield the names that do not belong to a method or fit that is on one side only."""
    unshared = set(before.sources) ^ set(after.sources)
    yield from (name for name in names if name.partition(": ")[0] not in unshared)
