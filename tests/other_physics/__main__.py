"""Judges the primary method on rigs of other physics: `PYTHONPATH=tests python -m other_physics`.

--rigs N       so many healthy rigs (20)
--faults N     so many rigs of each fault (0)
--scatter X    standard deviation of the gain from recording to recording (0.002)
--stated X     stations state the growth of the support's friction under load, within X (no)
--half 0|1     even seeds, on which methods are chosen (0), or odd ones, to judge them on (1)
"""

from __future__ import annotations

import argparse
import sys

import numpy as np

from other_physics.judged import Judged, judged
from other_physics.rigs import FAULTS, faulty, healthy

HEADER = (
    "| group | rigs | no result | rms mN·m | max mN·m | points in U | some check binds"
    " | inconclusive | verdicts | mean beyond U | beyond 2 U |"
)
SILENT = "| silent | seed | size | mean off by mN·m | U mN·m | checks in the budget |"


def main() -> None:
    """Print a row for healthy rigs and one for each fault."""
    parser = argparse.ArgumentParser(prog="other_physics")
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--faults", type=int, default=0)
    parser.add_argument("--scatter", type=float, default=0.002)
    parser.add_argument("--half", type=int, choices=(0, 1), default=0)
    parser.add_argument("--stated", type=float)
    asked = parser.parse_args()
    found: list[Judged] = []
    _head(HEADER)
    seeds = range(asked.half, 2 * asked.rigs, 2)
    found += [judged(healthy(seed, asked.scatter), asked.stated) for seed in seeds]
    _say(row("healthy", found))
    seeds = range(asked.half, 2 * asked.faults, 2)
    for group in FAULTS if asked.faults else ():
        of_group = [judged(faulty(group, seed), asked.stated) for seed in seeds]
        _say(row(group.name, of_group))
        found += of_group
    if asked.faults:
        faulty_ones = [each for each in found if each.pair.group != "healthy"]
        _say(row("all faults", faulty_ones))
    _head("\n" + SILENT)
    for each in found:
        if is_silent(each):
            _say(silent(each))


def row(group: str, found: list[Judged]) -> str:
    """Return the line of a group."""
    kept = [each for each in found if each.errors_nm]
    cells = [group, str(len(found)), str(len(found) - len(kept))]
    if kept:
        errors = np.concatenate([each.errors_nm for each in kept])
        expanded = np.concatenate([each.expanded_nm for each in kept])
        given = [each for each in kept if each.is_conclusive]
        cells += [
            f"{1e3 * np.sqrt(np.mean(errors**2)):.1f}",
            f"{1e3 * np.abs(errors).max():.1f}",
            f"{np.mean(np.abs(errors) <= expanded):.3f}",
            str(sum(bool(each.failed) for each in kept)),
            str(len(kept) - len(given)),
            str(len(given)),
            str(sum(_off(each) > 1 for each in given)),
            str(sum(_off(each) > 2 for each in given)),
        ]
    return "| " + " | ".join(cells) + " |"


def is_silent(found: Judged) -> bool:
    """Return whether a verdict stands on a mean that is off by more than U."""
    return bool(found.errors_nm) and found.is_conclusive and _off(found) > 1


def silent(found: Judged) -> str:
    """Return the line of a rig that no check catches."""
    pair = found.pair
    off, expanded = 1e3 * found.mean_error_nm, 1e3 * found.mean_expanded_nm
    cells = (pair.group, f"{pair.seed}", pair.size, f"{off:+.1f}", f"{expanded:.1f}")
    return "| " + " | ".join((*cells, ", ".join(found.failed))) + " |"


def _off(found: Judged) -> float:
    return abs(found.mean_error_nm) / found.mean_expanded_nm


def _head(cells: str) -> None:
    _say(cells)
    _say("|" + "---|" * (cells.count("|") - 1))


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
