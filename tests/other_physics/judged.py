"""A pair of runs analysed by the shipped procedure, and compared with the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from other_physics.recorded import recorded
from rigrunner.analysis.headline import compensated_mean
from rigrunner.api.analysis import Consequence
from rigrunner.api.errors import DataError
from rigrunner.signal.coverage import expanded
from rigrunner.study.tools import checks_of, primary_alone, tools

if TYPE_CHECKING:
    from pathlib import Path

    from other_physics.rigs import Pair
    from rigrunner.study.recording import RecordedBench


@dataclass(frozen=True)
class Judged:
    """What the primary method said of a pair; N.m, a value each set-point."""

    pair: Pair
    errors_nm: tuple[float, ...] = ()
    expanded_nm: tuple[float, ...] = ()
    mean_error_nm: float = np.nan
    mean_expanded_nm: float = np.nan
    failed: tuple[str, ...] = ()
    """Names of the checks that bind: in the budget, or inconclusive."""
    is_conclusive: bool = False
    """Whether no check forbids a verdict."""
    refused: str = ""
    """Why there is no result at all."""


def judged(
    pair: Pair,
    stated: float | None = None,
    cache: Path | None = None,
    *,
    bracketed: bool = False,
) -> Judged:
    """Record and analyse a pair; recordings are kept in the folder `cache`.

    With `stated` its station states the growth of the support's friction, with an error up to that.
    With `bracketed` there is a second no-load run, after the loaded one.
    """
    bench = recorded(pair, cache, bracketed=bracketed)
    if stated is not None:
        rig = bench.loaded.rig.model_copy(update=_growth(pair, stated))
        bench = replace(bench, loaded=replace(bench.loaded, rig=rig))
    return judged_by(pair, bench)


def judged_by(pair: Pair, bench: RecordedBench) -> Judged:
    """Analyse the recordings of a pair."""
    shared, truths = tools(), bench.truths_nm
    try:
        result = shared.analysed(bench, primary_alone(shared.spec))
    except DataError as error:
        return Judged(pair, refused=str(error))
    (found,) = result.compensations.values()
    failed = [each for each in checks_of(result) if not each.ok]
    if not found.points:
        return Judged(pair, refused=str(found.not_applicable))
    mean = compensated_mean(found.points)
    values = np.array([point.torque.value for point in found.points])
    return Judged(
        pair,
        errors_nm=tuple(values - truths),
        expanded_nm=tuple(expanded(point.torque) for point in found.points),
        mean_error_nm=float(mean.value - np.mean(truths)),
        mean_expanded_nm=expanded(mean),
        failed=tuple(each.name for each in failed),
        is_conclusive=not any(each.consequence is Consequence.INCONCLUSIVE for each in failed),
    )


def _growth(pair: Pair, limit: float) -> dict[str, float]:
    """Return what a station states that has measured it, within a limit of error."""
    under_load, free = pair.loaded.rig.support_coulomb_nm, pair.no_load.rig.support_coulomb_nm
    error = np.random.default_rng([pair.seed, 5]).uniform(-limit, limit)
    return {
        "support_load_growth": float(under_load / free - 1 + error),
        "support_load_dependence": limit,
    }
