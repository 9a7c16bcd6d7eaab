"""A pair of runs recorded, analysed by the shipped procedure, and compared with the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from other_physics.chain import RATE_HZ, measured
from other_physics.model import integrate, natural_hz, starting_torque_nm
from rigrunner.analysis.headline import compensated_mean
from rigrunner.api.analysis import Consequence
from rigrunner.api.data import Recording, RunData
from rigrunner.api.errors import DataError
from rigrunner.api.instruments import torque_instruments
from rigrunner.signal.coverage import expanded
from rigrunner.study.recording import RecordedBench
from rigrunner.study.tools import checks_of, primary_alone, tools

if TYPE_CHECKING:
    from numpy.random import Generator

    from other_physics.rigs import Pair, Run

ANGLE, TORQUE, LOAD = "tester.angle", "tester.torque", "tester.load"
SLOW_HZ, SETTLE_TURNS, ZERO_S, SET_S = 5.0, 4, 1.0, 5.0
SAID_N = 1000.0


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


def judged(pair: Pair, stated: float | None = None) -> Judged:
    """Record and analyse a pair.

    With `stated` its station states the growth of the support's friction, with an error up to that.
    """
    bench = recorded(pair)
    if stated is not None:
        rig = bench.loaded.rig.model_copy(update=_growth(pair, stated))
        bench = replace(bench, loaded=replace(bench.loaded, rig=rig))
    return judged_by(pair, bench)


def recorded(pair: Pair) -> RecordedBench:
    """Record both runs of a pair; this takes five times as long as the analysis."""
    no_load, _ = _recorded(
        pair, pair.no_load, "no-load", 0.0, np.random.default_rng([pair.seed, 3])
    )
    loaded, truths = _recorded(
        pair, pair.loaded, "loaded", SAID_N, np.random.default_rng([pair.seed, 4])
    )
    return RecordedBench(no_load, loaded, truths)


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


def _recorded(
    pair: Pair, run: Run, name: str, said_n: float, rng: Generator
) -> tuple[RunData, tuple[float, ...]]:
    now_s, recordings, truths = run.begun_s, [], []
    drift = run.chain.drift_nm * (1.0 - np.exp(-now_s / run.chain.drift_s))
    quiet = run.chain.noise_nm / np.sqrt(ZERO_S * RATE_HZ)
    zero = run.chain.zero_nm + drift + quiet * rng.standard_normal()
    for frequency_hz in pair.frequencies_hz:
        cycles = pair.cycles_of_slow if frequency_hz < SLOW_HZ else pair.cycles
        duration_s = (cycles + 1.5) / frequency_hz
        cold = run.warming * np.exp(-now_s / run.warming_s)
        friction = {
            each: getattr(run.rig, each) * (1.0 + cold)
            for each in ("support_coulomb_nm", "support_static_nm")
        }
        motion = integrate(run.rig._replace(**friction), frequency_hz, duration_s, SETTLE_TURNS)
        angle, torque = measured(motion, run.chain, now_s, rng)
        recordings.append(
            Recording(
                name=f"{frequency_hz:g} Hz",
                rate_hz=RATE_HZ,
                started_utc="2026-01-01T00:00:00.000Z",
                setpoints={"tester.frequency": frequency_hz, LOAD: said_n},
                channels={ANGLE: angle, TORQUE: torque},
                units={ANGLE: "rad", TORQUE: "N·m", "tester.frequency": "Hz", LOAD: "N"},
                conditions={LOAD: said_n},
            )
        )
        if said_n:
            truths.append(starting_torque_nm(motion))
        now_s += duration_s + SETTLE_TURNS / frequency_hz + SET_S
    station = tools().station
    (instrument,) = torque_instruments(station.instruments).values()
    known = {"natural_frequency": natural_hz(run.rig)}
    data = RunData(
        run_id=f"{name}-{pair.seed}",
        procedure_id=name,
        procedure_revision="",
        procedure_title=name,
        station_id=station.id,
        started_utc="2026-01-01T00:00:00.000Z",
        ended_utc="2026-01-01T01:00:00.000Z",
        outcome="completed",
        inputs={},
        rig=station.rig.model_copy(update=known),
        instruments={TORQUE: instrument},
        zeros={TORQUE: float(zero)},
        recordings=tuple(recordings),
    )
    return data, tuple(truths)
