"""Judges the primary method on rigs of other physics: `PYTHONPATH=tests python -m other_physics`.

--rigs N       so many healthy rigs (20)
--faults N     so many rigs of each fault (0)
--scatter X    standard deviation of the gain from recording to recording (0.002)
--stated X     healthy rigs again, whose stations state the growth of the support's friction under
               load, within X (no)
--group NAME   that fault alone; several may be named (all)
--bracketed    with a second no-load run, after the loaded one (no)
--measured     the station states what the load adds to the support, as a bearing of known friction
               showed it (no)
--load-read    a load cell tells what load was there in the no-load run (no)
--gains-known  the gain of every recording is taken out of it: a bound of what methods can do (no)
--half 0|1     even seeds, on which methods are chosen (0), or odd ones, to judge them on (1)
--cache DIR    keep the recordings there (no): to record takes five times as long as to analyse
"""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import binomtest

from other_physics.judged import Judged, judged
from other_physics.rigs import FAULTS, faulty, healthy

if TYPE_CHECKING:
    from collections.abc import Iterable

ACCURACY = (
    "| healthy rigs | rigs | rms mN·m | max mN·m | within 10 mN·m | points in U | means in U"
    " | median U of a point, of the mean, mN·m |"
)
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
    parser.add_argument("--group", action="append", choices=[each.name for each in FAULTS])
    parser.add_argument("--bracketed", action="store_true")
    parser.add_argument("--measured", action="store_true")
    parser.add_argument("--load-read", action="store_true")
    parser.add_argument("--gains-known", action="store_true")
    parser.add_argument("--half", type=int, choices=(0, 1), default=0)
    parser.add_argument("--stated", type=float)
    parser.add_argument("--cache", type=Path)
    asked = parser.parse_args()
    how = {
        "bracketed": asked.bracketed,
        "measured": asked.measured,
        "gains_known": asked.gains_known,
        "load_read": asked.load_read,
    }
    judge = partial(judged, cache=asked.cache, **how)
    rigs = [healthy(seed, asked.scatter) for seed in range(asked.half, 2 * asked.rigs, 2)]
    _head(ACCURACY)
    found = [judge(rig) for rig in rigs]
    _say(accuracy("growth not stated", found))
    if asked.stated is not None:
        stated = [judge(rig, stated=asked.stated) for rig in rigs]
        _say(accuracy(f"growth stated within {asked.stated:.1%}", stated))
    _head("\n" + HEADER)
    _say(row("healthy", found))
    seeds = range(asked.half, 2 * asked.faults, 2)
    groups = [each for each in FAULTS if not asked.group or each.name in asked.group]
    for group in groups if asked.faults else ():
        of_group = [judge(faulty(group, seed)) for seed in seeds]
        _say(row(group.name, of_group))
        found += of_group
    if asked.faults:
        faulty_ones = [each for each in found if each.pair.group != "healthy"]
        _say(row("all faults", faulty_ones))
    _head("\n" + SILENT)
    for each in found:
        if is_silent(each):
            _say(silent(each))


def accuracy(label: str, found: list[Judged]) -> str:
    """Return the line of rigs without a fault, with binomial intervals of the coverage."""
    kept = [each for each in found if each.errors_nm]
    errors = np.abs(np.concatenate([each.errors_nm for each in kept]))
    expanded = np.concatenate([each.expanded_nm for each in kept])
    of_mean = [each.mean_expanded_nm for each in kept]
    cells = (
        label,
        str(len(found)),
        f"{1e3 * np.sqrt(np.mean(errors**2)):.1f}",
        f"{1e3 * errors.max():.1f}",
        f"{np.mean(errors <= 0.01):.1%}",
        _covered(errors <= expanded),
        _covered([_off(each) <= 1 for each in kept]),
        f"{1e3 * np.median(expanded):.1f}, {1e3 * np.median(of_mean):.1f}",
    )
    return "| " + " | ".join(cells) + " |"


def _covered(inside: Iterable[bool]) -> str:
    """Return how many are inside, and the 95 % interval of Clopper and Pearson."""
    each = [bool(one) for one in inside]
    low, high = binomtest(sum(each), len(each)).proportion_ci(0.95)
    return f"{sum(each)} of {len(each)} ({100 * low:.1f} to {100 * high:.1f} %)"


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
