"""The outcome of all golden runs."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.errors import ExitCode
from rigrunner_fleet.golden.comparing import Standing
from rigrunner_fleet.golden.figures import HEADLINE

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner_fleet.golden.comparing import Comparison, Move

FORMAT = "rigrunner: golden check/1"


@dataclass(frozen=True)
class Spread:
    """Statistics of the changes."""

    n: int
    mean: float
    deviation: float | None
    """Their standard deviation; None for a single one."""
    largest: float
    """The largest one by magnitude, with its sign."""


@dataclass(frozen=True)
class AtFrequency:
    """The changes of the results at one set-point, over all runs that have it."""

    frequency_hz: float
    shift_nm: Spread
    in_u: Spread | None
    """In expanded uncertainties of the references; None if these had none."""


@dataclass(frozen=True, kw_only=True)
class Overall:
    """All golden runs, the most serious first."""

    runs: tuple[Comparison, ...]
    tolerance: float
    made_by: tuple[tuple[str, str, str], ...]
    """Changed software and settings: name, versions in the references and now."""

    @property
    def moved(self) -> tuple[Comparison, ...]:
        """The runs that a person has to check."""
        return tuple(run for run in self.runs if run.standing.moved)

    @property
    def exit_code(self) -> ExitCode:
        """5 if a run could not be compared, 1 if one changed, else 0."""
        if any(run.standing is Standing.NOT_COMPARED for run in self.runs):
            return ExitCode.DATA
        return ExitCode.FAIL if self.moved else ExitCode.PASS

    def counts(self) -> dict[Standing, int]:
        """Return the number of runs by outcome."""
        counts = Counter(run.standing for run in self.runs)
        return {standing: counts[standing] for standing in Standing if counts[standing]}

    def verdict_flips(self) -> dict[tuple[str, str], int]:
        """Return the number of runs by verdict before and now."""
        pairs = ((run.before.verdict, run.after.verdict) for run in self._compared_runs())
        return dict(Counter(pair for pair in pairs if pair[0] != pair[1]).most_common())

    def shifts_in_u(self) -> list[float]:
        """Return the change of every run's results in U of its reference, 0 if none changed."""
        shifts: list[float] = []
        for run in self._compared_runs():
            for name in (HEADLINE, *run.before.results):
                before, after = (snapshot.figures.get(name) for snapshot in (run.before, run.after))
                if before and after and before.expanded:
                    shifts.append((after.value - before.value) / before.expanded)
        return shifts

    def shifts(self) -> Spread | None:
        """Return the statistics of these; None if there are none."""
        shifts = self.shifts_in_u()
        return _spread(shifts) if shifts else None

    def by_frequency(self) -> list[AtFrequency]:
        """Return the changes of the results at each set-point, by frequency."""
        shifts: dict[float, list[tuple[float, float | None]]] = {}
        for run in self._compared_runs():
            for point in run.before.frequencies:
                before, after = (s.figures.get(point.figure) for s in (run.before, run.after))
                if before and after:
                    shift, u = after.value - before.value, before.expanded
                    pair = (shift, shift / u if u else None)
                    shifts.setdefault(point.frequency_hz, []).append(pair)
        rows = []
        for hz, pairs in sorted(shifts.items()):
            in_u = [u for _, u in pairs if u is not None]
            spread = _spread([shift for shift, _ in pairs])
            rows.append(AtFrequency(hz, spread, _spread(in_u) if in_u else None))
        return rows

    def document(self) -> dict[str, Any]:
        """Return the outcome for JSON."""
        return {
            "format": FORMAT,
            "tolerance_in_u": self.tolerance,
            "made_by": [
                {"name": name, "reference": then, "now": now} for name, then, now in self.made_by
            ],
            "counts": {str(standing): n for standing, n in self.counts().items()},
            "runs": [_run(run) for run in self.runs],
        }

    def _compared_runs(self) -> Iterator[Comparison]:
        skip = Standing.NOT_COMPARED
        return (run for run in self.runs if run.standing is not skip)


def _spread(values: list[float]) -> Spread:
    array = np.array(values)
    deviation = float(array.std(ddof=1)) if len(array) > 1 else None
    largest = float(array[np.abs(array).argmax()])
    return Spread(len(values), float(array.mean()), deviation, largest)


def _run(run: Comparison) -> Mapping[str, Any]:
    return {
        "run": run.name,
        "standing": str(run.standing),
        "problem": run.problem or None,
        "method": {"reference": run.before.method, "now": run.after.method},
        "verdict": {"reference": run.before.verdict, "now": run.after.verdict},
        "flips": [*run.flips.verdicts, *run.flips.checks],
        "moves": [_move(move) for move in run.moves],
    }


def _move(move: Move) -> Mapping[str, Any]:
    before, after = move.before, move.after
    figure = after or before
    return {
        "figure": move.name,
        "unit": figure.unit if figure else None,
        "reference": before and before.value,
        "expanded_uncertainty_95": before and before.expanded,
        "now": after and after.value,
        "expanded_uncertainty_95_now": after and after.expanded,
        "shift_in_u": move.in_u,
    }
