"""A pair of runs recorded, as the shipped procedure asks for it; kept in a folder if asked.

To record a pair takes five times as long as to analyse it.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from other_physics import chain, model
from other_physics.chain import RATE_HZ, measured
from other_physics.model import integrate, natural_hz, starting_torque_nm
from rigrunner.api.data import Recording, RunData
from rigrunner.api.instruments import torque_instruments
from rigrunner.study.recording import RecordedBench
from rigrunner.study.tools import tools

if TYPE_CHECKING:
    from numpy.random import Generator

    from other_physics.rigs import Pair, Run

ANGLE, TORQUE, LOAD = "tester.angle", "tester.torque", "tester.load"
SLOW_HZ, SETTLE_TURNS, ZERO_S, SET_S = 5.0, 4, 1.0, 5.0
SAID_N = 1000.0


class _Taken(NamedTuple):
    """What one run shows: steps of converter and encoder, (n,) for each set-point, and a zero."""

    torque: tuple[np.ndarray, ...]
    angle: tuple[np.ndarray, ...]
    zero_nm: float
    truths_nm: tuple[float, ...]


def recorded(pair: Pair, cache: Path | None = None) -> RecordedBench:
    """Record both runs of a pair, or read them where they are kept."""
    no_load, loaded = _kept(pair, cache) if cache else _taken(pair)
    return RecordedBench(
        _run_data(pair, pair.no_load, no_load, "no-load", 0.0),
        _run_data(pair, pair.loaded, loaded, "loaded", SAID_N),
        loaded.truths_nm,
    )


def _taken(pair: Pair) -> tuple[_Taken, _Taken]:
    return (
        _take(pair, pair.no_load, np.random.default_rng([pair.seed, 3])),
        _take(pair, pair.loaded, np.random.default_rng([pair.seed, 4])),
    )


def _kept(pair: Pair, cache: Path) -> tuple[_Taken, _Taken]:
    """Return both runs from a file; its name changes with the pair and with the simulator."""
    sources = [Path(each.__file__).read_bytes() for each in (chain, model)]
    name = hashlib.sha256(b"".join([repr(pair).encode(), *sources])).hexdigest()
    path = cache / f"{name}.npz"
    if not path.exists():
        cache.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part.npz")
        np.savez_compressed(part, **_arrays(_taken(pair)))
        part.replace(path)
    with np.load(path) as file:
        stored = dict(file)
    return _of_arrays(stored, "no-load"), _of_arrays(stored, "loaded")


def _arrays(both: tuple[_Taken, _Taken]) -> dict[str, np.ndarray]:
    return {
        f"{name} {field}": np.concatenate(value) if field in {"torque", "angle"} else value
        for name, run in zip(("no-load", "loaded"), both, strict=True)
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
        cycles = pair.cycles_of_slow if frequency_hz < SLOW_HZ else pair.cycles
        duration_s = (cycles + 1.5) / frequency_hz
        cold = run.warming * np.exp(-now_s / run.warming_s)
        friction = {
            each: getattr(run.rig, each) * (1.0 + cold)
            for each in ("support_coulomb_nm", "support_static_nm")
        }
        motion = integrate(run.rig._replace(**friction), frequency_hz, duration_s, SETTLE_TURNS)
        angle, torque = measured(motion, run.chain, now_s, rng)
        angles.append(np.rint(angle / run.chain.encoder_step_rad).astype(np.int32))
        torques.append(np.rint(torque / run.chain.step_nm).astype(np.int32))
        truths.append(starting_torque_nm(motion) if run is pair.loaded else 0.0)
        now_s += duration_s + SETTLE_TURNS / frequency_hz + SET_S
    return _Taken(tuple(torques), tuple(angles), float(zero), tuple(truths))


def _run_data(pair: Pair, run: Run, taken: _Taken, name: str, said_n: float) -> RunData:
    station = tools().station
    (instrument,) = torque_instruments(station.instruments).values()
    known = {"natural_frequency": natural_hz(run.rig)}
    recordings = tuple(
        Recording(
            name=f"{frequency_hz:g} Hz",
            rate_hz=RATE_HZ,
            started_utc="2026-01-01T00:00:00.000Z",
            setpoints={"tester.frequency": frequency_hz, LOAD: said_n},
            channels={
                ANGLE: run.chain.encoder_step_rad * angle,
                TORQUE: run.chain.step_nm * torque,
            },
            units={ANGLE: "rad", TORQUE: "N·m", "tester.frequency": "Hz", LOAD: "N"},
            conditions={LOAD: said_n},
        )
        for frequency_hz, angle, torque in zip(
            pair.frequencies_hz, taken.angle, taken.torque, strict=True
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
        rig=station.rig.model_copy(update=known),
        instruments={TORQUE: instrument},
        zeros={TORQUE: taken.zero_nm},
        recordings=recordings,
    )
