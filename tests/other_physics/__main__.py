"""Judges the primary method on rigs of other physics: `PYTHONPATH=tests python -m other_physics`.

--rigs N       so many healthy rigs (20)
--faults N     so many rigs of each fault (0)
--scatter X    standard deviation of the gain from recording to recording (0.002)
--half 0|1     even seeds, on which methods are chosen (0), or odd ones, to judge them on (1)
"""

from __future__ import annotations

import argparse
import sys

import numpy as np

from other_physics.judged import Judged, judged
from other_physics.rigs import FAULTS, faulty, healthy

HEADER = (
    "| group | rigs | no result | rms mN·m | max mN·m | points in U | means in U | max mean / U"
    " | some check failed | inconclusive |"
)


def main() -> None:
    """Print a row for healthy rigs and one for each fault."""
    parser = argparse.ArgumentParser(prog="other_physics")
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--faults", type=int, default=0)
    parser.add_argument("--scatter", type=float, default=0.002)
    parser.add_argument("--half", type=int, choices=(0, 1), default=0)
    asked = parser.parse_args()
    _say(HEADER)
    _say("|" + "---|" * (HEADER.count("|") - 1))
    seeds = range(asked.half, 2 * asked.rigs, 2)
    _say(_row("healthy", [judged(healthy(seed, asked.scatter)) for seed in seeds]))
    if asked.faults:
        seeds = range(asked.half, 2 * asked.faults, 2)
        for group in FAULTS:
            _say(_row(group.name, [judged(faulty(group, seed)) for seed in seeds]))


def _row(group: str, found: list[Judged]) -> str:
    kept = [each for each in found if each.errors_nm]
    cells = [group, str(len(found)), str(len(found) - len(kept))]
    if kept:
        errors = np.concatenate([each.errors_nm for each in kept])
        expanded = np.concatenate([each.expanded_nm for each in kept])
        means = np.array([abs(each.mean_error_nm) / each.mean_expanded_nm for each in kept])
        cells += [
            f"{1e3 * np.sqrt(np.mean(errors**2)):.1f}",
            f"{1e3 * np.abs(errors).max():.1f}",
            f"{np.mean(np.abs(errors) <= expanded):.3f}",
            f"{int(np.sum(means <= 1))} of {len(means)}",
            f"{means.max():.1f}",
            str(sum(bool(each.failed) for each in kept)),
            str(sum(not each.is_conclusive for each in kept)),
        ]
    return "| " + " | ".join(cells) + " |"


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
