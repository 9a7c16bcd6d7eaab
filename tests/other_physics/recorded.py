"""Records a pair of runs as the shipped procedure does, with an optional cache folder.

Recording a pair takes five times as long as analysing it.
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
STATED_N = 1000.0
START = datetime(2026, 1, 1, tzinfo=UTC)


class _RunSamples(NamedTuple):
    """The data of one run: steps of converter and encoder, (n,) for each set-point, and a zero."""

    torque: tuple[np.ndarray, ...]
    angle: tuple[np.ndarray, ...]
    zero_nm: float
    truths_nm: tuple[float, ...]


def record_pair(pair: Pair, cache: Path | None = None, *, bracketed: bool = False) -> RecordedBench:
    """Record both runs of a pair, optionally with a no-load run after; or read them from cache."""
    no_load, loaded = _cached_runs(pair, cache, _PAIR)
    after = _cached_runs(pair, cache, _AFTER)[0] if bracketed else None
    return RecordedBench(
        _run_data(pair, pair.no_load, no_load, "no-load", 0.0),
        _run_data(pair, pair.loaded, loaded, "loaded", STATED_N),
        loaded.truths_nm,
        None if after is None else _run_data(pair, run_after(pair), after, "after", 0.0),
    )


def record_known_bearing(pair: Pair, cache: Path | None = None) -> RecordedBench:
    """Record the loaded run with a bearing of known friction, after the same no-load run."""
    no_load, _ = _cached_runs(pair, cache, _PAIR)
    (loaded,) = _cached_runs(known_bearing(pair), cache, _LOADED)
    return RecordedBench(
        _run_data(pair, pair.no_load, no_load, "no-load", 0.0),
        _run_data(pair, pair.loaded, loaded, "known", STATED_N),
        loaded.truths_nm,
    )


def without_scatter(pair: Pair, bench: RecordedBench) -> RecordedBench:
    """Return both runs with the gain of every recording removed; in practice it is unknown."""
    return replace(
        bench,
        no_load=_without_gains(pair, pair.no_load, bench.no_load, "no-load"),
        loaded=_without_gains(pair, pair.loaded, bench.loaded, "loaded"),
    )


def _without_gains(pair: Pair, run: Run, data: RunData, name: str) -> RunData:
    """Repeat the draws of `_record_run` and `measured` in their order, to get the gains."""
    rng = np.random.default_rng([pair.seed, _SEED[name]])
    rng.standard_normal()  # of the zero
    recordings = []
    for recording in data.recordings:
        gain = 1.0 + run.chain.recording_gain * rng.standard_normal()
        rng.uniform()  # the phase of the hum
        rng.standard_normal(2 * recording.samples)  # noise of torque and angle
        channels = {**recording.channels, TORQUE: np.asarray(recording.channels[TORQUE]) / gain}
        recordings.append(replace(recording, channels=channels))
    return replace(data, recordings=tuple(recordings))


_PAIR, _AFTER, _LOADED = ("no-load", "loaded"), ("after",), ("loaded",)
_SEED = {"no-load": 3, "loaded": 4, "after": 7}


def _record_runs(pair: Pair, names: Sequence[str]) -> list[_RunSamples]:
    runs = {"no-load": pair.no_load, "loaded": pair.loaded, "after": run_after(pair)}
    return [
        _record_run(pair, runs[name], np.random.default_rng([pair.seed, _SEED[name]]))
        for name in names
    ]


def _cached_runs(pair: Pair, cache: Path | None, names: Sequence[str]) -> list[_RunSamples]:
    """Return runs from a cache file, whose name depends on the pair and the simulator."""
    if cache is None:
        return _record_runs(pair, names)
    key_parts = [repr(pair)]
    key_parts += [] if names == _PAIR else [*names] if names == _LOADED else [repr(run_after(pair))]
    sources = [Path(module.__file__).read_bytes() for module in (chain, model)]
    name = hashlib.sha256(b"".join([*(part.encode() for part in key_parts), *sources])).hexdigest()
    path = cache / f"{name}.npz"
    if not path.exists():
        cache.mkdir(parents=True, exist_ok=True)
        partial = path.with_suffix(".part.npz")
        np.savez_compressed(
            partial, **_arrays(dict(zip(names, _record_runs(pair, names), strict=True)))
        )
        partial.replace(path)
    with np.load(path) as file:
        stored = dict(file)
    return [_of_arrays(stored, name) for name in names]


def _arrays(runs: Mapping[str, _RunSamples]) -> dict[str, np.ndarray]:
    return {
        f"{name} {field}": np.concatenate(value) if field in {"torque", "angle"} else value
        for name, run in runs.items()
        for field, value in {
            **run._asdict(),
            "lengths": [len(samples) for samples in run.torque],
        }.items()
    }


def _of_arrays(stored: dict[str, np.ndarray], name: str) -> _RunSamples:
    ends = np.cumsum(stored[f"{name} lengths"])[:-1]
    return _RunSamples(
        torque=tuple(np.split(stored[f"{name} torque"], ends)),
        angle=tuple(np.split(stored[f"{name} angle"], ends)),
        zero_nm=float(stored[f"{name} zero_nm"]),
        truths_nm=tuple(map(float, stored[f"{name} truths_nm"])),
    )


def _record_run(pair: Pair, run: Run, rng: Generator) -> _RunSamples:
    now_s, torques, angles, truths = run.begun_s, [], [], []
    drift = run.chain.drift_nm * (1.0 - np.exp(-now_s / run.chain.drift_s))
    quiet = run.chain.noise_nm / np.sqrt(ZERO_S * RATE_HZ)
    zero = run.chain.zero_nm + drift + quiet * rng.standard_normal()
    for frequency_hz in pair.frequencies_hz:
        duration_s = _duration_s(pair, frequency_hz)
        cold = run.warming * np.exp(-now_s / run.warming_s)
        friction = {
            name: getattr(run.rig, name) * (1.0 + cold)
            for name in ("support_coulomb_nm", "support_static_nm")
        }
        motion = integrate(run.rig._replace(**friction), frequency_hz, duration_s, SETTLE_TURNS)
        angle, torque = measured(motion, run.chain, now_s, rng)
        angles.append(np.rint(angle / run.chain.encoder_step_rad).astype(np.int32))
        torques.append(np.rint(torque / run.chain.step_nm).astype(np.int32))
        truths.append(starting_torque_nm(motion) if run.load_n == LOAD_N else 0.0)
        now_s += duration_s + SETTLE_TURNS / frequency_hz + SET_S
    return _RunSamples(tuple(torques), tuple(angles), float(zero), tuple(truths))


def _starts_s(pair: Pair) -> list[float]:
    """Return the start of each recording, in s after the start of its run."""
    durations_s = [_duration_s(pair, f) + SETTLE_TURNS / f + SET_S for f in pair.frequencies_hz]
    return [sum(durations_s[:number]) for number in range(len(durations_s))]


def _duration_s(pair: Pair, frequency_hz: float) -> float:
    cycles = pair.cycles_of_slow if frequency_hz < SLOW_HZ else pair.cycles
    return (cycles + 1.5) / frequency_hz


def _run_data(pair: Pair, run: Run, samples: _RunSamples, name: str, stated_n: float) -> RunData:
    station = tools().station
    (instrument,) = torque_instruments(station.instruments).values()
    keys = {
        "natural_frequency": f"{float(natural_hz(run.rig))!r} Hz",
    }
    rig_keys = {key: value for key, value in station.rig.items() if key != "support_drift"}
    recordings = tuple(
        Recording(
            name=f"{frequency_hz:g} Hz",
            rate_hz=RATE_HZ,
            started_utc=utc_text(START + timedelta(seconds=run.begun_s + at_s)),
            setpoints={"tester.frequency": frequency_hz, LOAD: stated_n},
            channels={
                ANGLE: run.chain.encoder_step_rad * angle,
                TORQUE: run.chain.step_nm * torque,
            },
            units={ANGLE: "rad", TORQUE: "N·m", "tester.frequency": "Hz", LOAD: "N"},
            conditions={LOAD: stated_n},
        )
        for frequency_hz, angle, torque, at_s in zip(
            pair.frequencies_hz, samples.angle, samples.torque, _starts_s(pair), strict=True
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
        rig_keys=rig_keys | keys,  # the supports of these rigs warm up
        instruments={TORQUE: instrument},
        zeros={TORQUE: samples.zero_nm},
        recordings=recordings,
    )
