"""Judges the primary method on rigs of other physics: `PYTHONPATH=tests python -m other_physics`.

--rigs N       so many healthy rigs (20)
--faults N     so many rigs of each fault (0)
--scatter X    standard deviation of the gain from recording to recording (0.002)
--stated X     healthy rigs again, whose stations state the growth of the support's friction under
               load, within X (no)
--group NAME   that fault alone; several may be named (all)
--bracketed    with a second no-load run, after the loaded one (no)
--measured     the station states what the load adds to the support, as measured with a
               bearing of known friction (no)
--load-read    a load cell measures the load of the no-load run (no)
--gains-known  the gain of every recording is removed: a bound of what methods can do (no)
--half 0|1     even seeds, on which methods are chosen (0), or odd ones, to judge them on (1)
--cache DIR    keep the recordings there (no): recording takes five times as long as analysing
"""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import binomtest

from other_physics.judged import Judgement, judge
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
    parser.add_argument("--group", action="append", choices=[fault.name for fault in FAULTS])
    parser.add_argument("--bracketed", action="store_true")
    parser.add_argument("--measured", action="store_true")
    parser.add_argument("--load-read", action="store_true")
    parser.add_argument("--gains-known", action="store_true")
    parser.add_argument("--half", type=int, choices=(0, 1), default=0)
    parser.add_argument("--stated", type=float)
    parser.add_argument("--cache", type=Path)
    args = parser.parse_args()
    options = {
        "bracketed": args.bracketed,
        "measured": args.measured,
        "gains_known": args.gains_known,
        "load_read": args.load_read,
    }
    judge_rig = partial(judge, cache=args.cache, **options)
    rigs = [healthy(seed, args.scatter) for seed in range(args.half, 2 * args.rigs, 2)]
    _write_header(ACCURACY)
    results = [judge_rig(rig) for rig in rigs]
    _write(accuracy("growth not stated", results))
    if args.stated is not None:
        stated = [judge_rig(rig, stated=args.stated) for rig in rigs]
        _write(accuracy(f"growth stated within {args.stated:.1%}", stated))
    _write_header("\n" + HEADER)
    _write(row("healthy", results))
    seeds = range(args.half, 2 * args.faults, 2)
    groups = [fault for fault in FAULTS if not args.group or fault.name in args.group]
    for group in groups if args.faults else ():
        group_results = [judge_rig(faulty(group, seed)) for seed in seeds]
        _write(row(group.name, group_results))
        results += group_results
    if args.faults:
        faulty_results = [result for result in results if result.pair.group != "healthy"]
        _write(row("all faults", faulty_results))
    _write_header("\n" + SILENT)
    for result in results:
        if is_silent(result):
            _write(silent(result))


def accuracy(label: str, results: list[Judgement]) -> str:
    """Return the line of rigs without a fault, with binomial intervals of the coverage."""
    kept = [result for result in results if result.errors_nm]
    errors = np.abs(np.concatenate([result.errors_nm for result in kept]))
    expanded = np.concatenate([result.expanded_nm for result in kept])
    of_mean = [result.mean_expanded_nm for result in kept]
    cells = (
        label,
        str(len(results)),
        f"{1e3 * np.sqrt(np.mean(errors**2)):.1f}",
        f"{1e3 * errors.max():.1f}",
        f"{np.mean(errors <= 0.01):.1%}",
        _covered(errors <= expanded),
        _covered([_relative_error(result) <= 1 for result in kept]),
        f"{1e3 * np.median(expanded):.1f}, {1e3 * np.median(of_mean):.1f}",
    )
    return "| " + " | ".join(cells) + " |"


def _covered(inside: Iterable[bool]) -> str:
    """Return how many are inside, and the 95 % interval of Clopper and Pearson."""
    flags = [bool(flag) for flag in inside]
    low, high = binomtest(sum(flags), len(flags)).proportion_ci(0.95)
    return f"{sum(flags)} of {len(flags)} ({100 * low:.1f} to {100 * high:.1f} %)"


def row(group: str, results: list[Judgement]) -> str:
    """Return the line of a group."""
    kept = [result for result in results if result.errors_nm]
    cells = [group, str(len(results)), str(len(results) - len(kept))]
    if kept:
        errors = np.concatenate([result.errors_nm for result in kept])
        expanded = np.concatenate([result.expanded_nm for result in kept])
        conclusive = [result for result in kept if result.is_conclusive]
        cells += [
            f"{1e3 * np.sqrt(np.mean(errors**2)):.1f}",
            f"{1e3 * np.abs(errors).max():.1f}",
            f"{np.mean(np.abs(errors) <= expanded):.3f}",
            str(sum(bool(result.failed) for result in kept)),
            str(len(kept) - len(conclusive)),
            str(len(conclusive)),
            str(sum(_relative_error(result) > 1 for result in conclusive)),
            str(sum(_relative_error(result) > 2 for result in conclusive)),
        ]
    return "| " + " | ".join(cells) + " |"


def is_silent(judgement: Judgement) -> bool:
    """Return whether there is a verdict although the mean is wrong by more than U."""
    return bool(judgement.errors_nm) and judgement.is_conclusive and _relative_error(judgement) > 1


def silent(judgement: Judgement) -> str:
    """Return the line of a rig that no check catches."""
    pair = judgement.pair
    error_nm, expanded = 1e3 * judgement.mean_error_nm, 1e3 * judgement.mean_expanded_nm
    cells = (pair.group, f"{pair.seed}", pair.size, f"{error_nm:+.1f}", f"{expanded:.1f}")
    return "| " + " | ".join((*cells, ", ".join(judgement.failed))) + " |"


def _relative_error(judgement: Judgement) -> float:
    return abs(judgement.mean_error_nm) / judgement.mean_expanded_nm


def _write_header(cells: str) -> None:
    _write(cells)
    _write("|" + "---|" * (cells.count("|") - 1))


def _write(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
