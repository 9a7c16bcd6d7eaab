"""A pair of runs recorded, as the shipped procedure asks for it; kept in a folder if asked.

To record a pair takes five times as long as to analyse it.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from other_physics import chain, model
from other_physics.chain import RATE_HZ, measured
from other_physics.model import integrate, natural_hz, starting_torque_nm
from other_physics.rigs import LOAD_N, known_bearing, run_after
from rigrunner.api.data import Recording, RunData
from rigrunner.clock import utc_text
from rigrunner_bearings.api.rig import torque_instruments
from rigrunner_bearings.study.recording import RecordedBench
from rigrunner_bearings.study.tools import tools

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.random import Generator

    from other_physics.rigs import Pair, Run

ANGLE, TORQUE, LOAD = "tester.angle", "tester.torque", "tester.load"
SLOW_HZ, SETTLE_TURNS, ZERO_S, SET_S = 5.0, 4, 1.0, 5.0
SAID_N = 1000.0
BEGUN = datetime(2026, 1, 1, tzinfo=UTC)


class _Taken(NamedTuple):
    """What one run shows: steps of converter and encoder, (n,) for each set-point, and a zero."""

    torque: tuple[np.ndarray, ...]
    angle: tuple[np.ndarray, ...]
    zero_nm: float
    truths_nm: tuple[float, ...]


def recorded(pair: Pair, cache: Path | None = None, *, bracketed: bool = False) -> RecordedBench:
    """Record both runs of a pair, and if asked a no-load run after; or read them where kept."""
    no_load, loaded = _kept(pair, cache, _PAIR)
    after = _kept(pair, cache, _AFTER)[0] if bracketed else None
    return RecordedBench(
        _run_data(pair, pair.no_load, no_load, "no-load", 0.0),
        _run_data(pair, pair.loaded, loaded, "loaded", SAID_N),
        loaded.truths_nm,
        None if after is None else _run_data(pair, run_after(pair), after, "after", 0.0),
    )


def recorded_known(pair: Pair, cache: Path | None = None) -> RecordedBench:
    """Record the loaded run with a bearing of known friction, after the same no-load run."""
    no_load, _ = _kept(pair, cache, _PAIR)
    (loaded,) = _kept(known_bearing(pair), cache, _LOADED)
    return RecordedBench(
        _run_data(pair, pair.no_load, no_load, "no-load", 0.0),
        _run_data(pair, pair.loaded, loaded, "known", SAID_N),
        loaded.truths_nm,
    )


def without_scatter(pair: Pair, bench: RecordedBench) -> RecordedBench:
    """Return both runs with the gain of every recording taken out, as nobody can know it."""
    return replace(
        bench,
        no_load=_over_gains(pair, pair.no_load, bench.no_load, "no-load"),
        loaded=_over_gains(pair, pair.loaded, bench.loaded, "loaded"),
    )


def _over_gains(pair: Pair, run: Run, data: RunData, name: str) -> RunData:
    """Draw once more what `_take` and `measured` drew, in their order; the gains are among it."""
    rng = np.random.default_rng([pair.seed, _SEED[name]])
    rng.standard_normal()  # of the zero
    recordings = []
    for each in data.recordings:
        gain = 1.0 + run.chain.recording_gain * rng.standard_normal()
        rng.uniform()  # the phase of the hum
        rng.standard_normal(2 * each.samples)  # noise of torque and angle
        channels = {**each.channels, TORQUE: np.asarray(each.channels[TORQUE]) / gain}
        recordings.append(replace(each, channels=channels))
    return replace(data, recordings=tuple(recordings))


_PAIR, _AFTER, _LOADED = ("no-load", "loaded"), ("after",), ("loaded",)
_SEED = {"no-load": 3, "loaded": 4, "after": 7}


def _taken(pair: Pair, names: Sequence[str]) -> list[_Taken]:
    runs = {"no-load": pair.no_load, "loaded": pair.loaded, "after": run_after(pair)}
    return [
        _take(pair, runs[name], np.random.default_rng([pair.seed, _SEED[name]])) for name in names
    ]


def _kept(pair: Pair, cache: Path | None, names: Sequence[str]) -> list[_Taken]:
    """Return runs from a file; its name changes with the pair and with the simulator."""
    if cache is None:
        return _taken(pair, names)
    what = [repr(pair)]
    what += [] if names == _PAIR else [*names] if names == _LOADED else [repr(run_after(pair))]
    sources = [Path(each.__file__).read_bytes() for each in (chain, model)]
    name = hashlib.sha256(b"".join([*(each.encode() for each in what), *sources])).hexdigest()
    path = cache / f"{name}.npz"
    if not path.exists():
        cache.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part.npz")
        np.savez_compressed(part, **_arrays(dict(zip(names, _taken(pair, names), strict=True))))
        part.replace(path)
    with np.load(path) as file:
        stored = dict(file)
    return [_of_arrays(stored, name) for name in names]


def _arrays(runs: Mapping[str, _Taken]) -> dict[str, np.ndarray]:
    return {
        f"{name} {field}": np.concatenate(value) if field in {"torque", "angle"} else value
        for name, run in runs.items()
        for field, value in {
            **run._asdict(),
            "lengths": [len(each) for each in run.torque],
        }.items()
    }


def _of_arrays(stored: dict[str, np.ndarray], name: str) -> _Taken:
    ends = np.cumsum(stored[f"{name} lengths"])[:-1]
    return _Taken(
        torque=tuple(np.split(stored[f"{name} torque"], ends)),
        angle=tuple(np.split(stored[f"{name} angle"], ends)),
        zero_nm=float(stored[f"{name} zero_nm"]),
        truths_nm=tuple(map(float, stored[f"{name} truths_nm"])),
    )


def _take(pair: Pair, run: Run, rng: Generator) -> _Taken:
    now_s, torques, angles, truths = run.begun_s, [], [], []
    drift = run.chain.drift_nm * (1.0 - np.exp(-now_s / run.chain.drift_s))
    quiet = run.chain.noise_nm / np.sqrt(ZERO_S * RATE_HZ)
    zero = run.chain.zero_nm + drift + quiet * rng.standard_normal()
    for frequency_hz in pair.frequencies_hz:
        duration_s = _duration_s(pair, frequency_hz)
        cold = run.warming * np.exp(-now_s / run.warming_s)
        friction = {
            each: getattr(run.rig, each) * (1.0 + cold)
            for each in ("support_coulomb_nm", "support_static_nm")
        }
        motion = integrate(run.rig._replace(**friction), frequency_hz, duration_s, SETTLE_TURNS)
        angle, torque = measured(motion, run.chain, now_s, rng)
        angles.append(np.rint(angle / run.chain.encoder_step_rad).astype(np.int32))
        torques.append(np.rint(torque / run.chain.step_nm).astype(np.int32))
        truths.append(starting_torque_nm(motion) if run.load_n == LOAD_N else 0.0)
        now_s += duration_s + SETTLE_TURNS / frequency_hz + SET_S
    return _Taken(tuple(torques), tuple(angles), float(zero), tuple(truths))


def _begins(pair: Pair) -> list[float]:
    """Return when each recording begins, in s after its run."""
    lasts = [_duration_s(pair, f) + SETTLE_TURNS / f + SET_S for f in pair.frequencies_hz]
    return [sum(lasts[:number]) for number in range(len(lasts))]


def _duration_s(pair: Pair, frequency_hz: float) -> float:
    cycles = pair.cycles_of_slow if frequency_hz < SLOW_HZ else pair.cycles
    return (cycles + 1.5) / frequency_hz


def _run_data(pair: Pair, run: Run, taken: _Taken, name: str, said_n: float) -> RunData:
    station = tools().station
    (instrument,) = torque_instruments(station.instruments).values()
    known = {
        "natural_frequency": f"{float(natural_hz(run.rig))!r} Hz",
    }
    warm = {key: each for key, each in station.rig.items() if key != "support_drift"}
    recordings = tuple(
        Recording(
            name=f"{frequency_hz:g} Hz",
            rate_hz=RATE_HZ,
            started_utc=utc_text(BEGUN + timedelta(seconds=run.begun_s + at_s)),
            setpoints={"tester.frequency": frequency_hz, LOAD: said_n},
            channels={
                ANGLE: run.chain.encoder_step_rad * angle,
                TORQUE: run.chain.step_nm * torque,
            },
            units={ANGLE: "rad", TORQUE: "N·m", "tester.frequency": "Hz", LOAD: "N"},
            conditions={LOAD: said_n},
        )
        for frequency_hz, angle, torque, at_s in zip(
            pair.frequencies_hz, taken.angle, taken.torque, _begins(pair), strict=True
        )
    )
    return RunData(
        run_id=f"{name}-{pair.seed}",
        procedure_id=name,
        procedure_revision="",
        procedure_title=name,
        station_id=station.id,
        started_utc="2026-01-01T00:00:00.000Z",
        ended_utc="2026-01-01T01:00:00.000Z",
        outcome="completed",
        inputs={},
        rig_keys=warm | known,  # these supports become warm
        instruments={TORQUE: instrument},
        zeros={TORQUE: taken.zero_nm},
        recordings=recordings,
    )
