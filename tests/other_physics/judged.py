"""A pair of runs analysed by the shipped procedure, and compared with the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from other_physics.recorded import LOAD, record_known_bearing, record_pair, without_scatter
from rigrunner.api.analysis import Consequence
from rigrunner.api.errors import DataError
from rigrunner.signal.coverage import expanded
from rigrunner_bearings.api.rig import SupportUnderLoad
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.known_bearing import MOST, RUNNING, between
from rigrunner_bearings.study.tools import checks_of, primary_alone, tools
from rigrunner_bearings.torque.headline import compensated_mean

if TYPE_CHECKING:
    from pathlib import Path

    from other_physics.rigs import Pair
    from rigrunner.api.data import RunData
    from rigrunner_bearings.study.recording import RecordedBench


KNOWN_LIMIT_NM = 0.002


@dataclass(frozen=True)
class Judgement:
    """Results of the primary method for a pair, in N.m, one value per set-point."""

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


def judge(
    pair: Pair,
    stated: float | None = None,
    cache: Path | None = None,
    *,
    bracketed: bool = False,
    measured: bool = False,
    gains_known: bool = False,
    load_read: bool = False,
) -> Judgement:
    """Record and analyse a pair; recordings are kept in the folder `cache`.

    With `stated` its station states the growth of the support's friction, with an error up to that.
    With `bracketed` there is a second no-load run, after the loaded one. With `measured` its
    station states what the load adds to the support, as a bearing of known friction showed. With
    `gains_known` the gain of every recording is removed, which bounds what a method can do.
    With `load_read` a load cell measures the load of the no-load run.
    """
    bench = record_pair(pair, cache, bracketed=bracketed)
    if gains_known:
        bench = without_scatter(pair, bench)
    if load_read:
        bench = replace(bench, no_load=_with_load(bench.no_load, pair.no_load.load_n))
    if stated is not None:
        bench = replace(bench, loaded=_stating(bench.loaded, _growth(pair, stated)))
    if measured:
        keys = _measured(pair, cache)
        added_nm = SupportUnderLoad.model_validate(keys).torque
        if added_nm > MOST * pair.no_load.rig.support_coulomb_nm:
            return Judgement(pair, refused="the load adds too much to the support")
        bench = replace(bench, loaded=_stating(bench.loaded, {"support_under_load": keys}))
    return judge_bench(pair, bench)


def judge_bench(pair: Pair, bench: RecordedBench) -> Judgement:
    """Analyse the recordings of a pair."""
    shared, truths = tools(), bench.truths_nm
    try:
        result = shared.analysed(bench, primary_alone(shared.spec))
    except DataError as error:
        return Judgement(pair, refused=str(error))
    (compensation,) = TorqueDetails.of(result).compensations.values()
    failed = [check for check in checks_of(result) if not check.ok]
    if not compensation.points:
        return Judgement(pair, refused=str(compensation.not_applicable))
    mean = compensated_mean(compensation.points)
    values = np.array([point.torque.value for point in compensation.points])
    return Judgement(
        pair,
        errors_nm=tuple(values - truths),
        expanded_nm=tuple(expanded(point.torque) for point in compensation.points),
        mean_error_nm=float(mean.value - np.mean(truths)),
        mean_expanded_nm=expanded(mean),
        failed=tuple(check.name for check in failed),
        is_conclusive=not any(check.consequence is Consequence.INCONCLUSIVE for check in failed),
    )


def _with_load(run: RunData, load_n: float) -> RunData:
    recordings = (replace(recording, conditions={LOAD: load_n}) for recording in run.recordings)
    return replace(run, recordings=tuple(recordings))


def _stating(run: RunData, keys: dict[str, Any]) -> RunData:
    """Return the run of a rig whose station states these keys."""
    return replace(run, rig_keys={**run.rig_keys, **keys})


def _measured(pair: Pair, cache: Path | None) -> dict[str, str]:
    """Return the torque that the load adds to the support, by a bearing known to 2 mN.m."""
    bench, shared = record_known_bearing(pair, cache), tools()
    bench = replace(bench, loaded=_stating(bench.loaded, {"support_load_dependence": "0 %"}))
    compensations = TorqueDetails.of(shared.analysed(bench, shared.spec)).compensations
    mean, under_way = (
        compensated_mean(compensations[name].points) for name in (shared.spec.primary, RUNNING)
    )
    total, (slip,) = between(mean.value, under_way.value)
    error = np.random.default_rng([pair.seed, 8]).uniform(-KNOWN_LIMIT_NM, KNOWN_LIMIT_NM)
    torque = total - bench.truth_nm + error
    u = np.sqrt(mean.u**2 + slip.u**2 + KNOWN_LIMIT_NM**2 / 3)
    keys = {"source": "known bearing", "load": "1000 N"}
    return {**keys, "torque": f"{torque:.6f} N·m", "u": f"{u:.6f} N·m"}


def _growth(pair: Pair, limit: float) -> dict[str, str]:
    """Return the keys of a station that has measured the growth within a limit of error."""
    under_load, free = pair.loaded.rig.support_coulomb_nm, pair.no_load.rig.support_coulomb_nm
    error = np.random.default_rng([pair.seed, 5]).uniform(-limit, limit)
    return {
        "support_load_growth": f"{100 * float(under_load / free - 1 + error)!r} %",
        "support_load_dependence": f"{100 * limit!r} %",
    }
