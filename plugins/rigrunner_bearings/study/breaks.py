"""The ways in which a study breaks a healthy rig, and the check that must detect each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner_bearings.study.bench import LOAD_N, NATURAL, Value, scaled, with_inertia
from rigrunner_bearings.study.diagnostics_rigs import POPULATIONS

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator

    from rigrunner_bearings.study.bench import Bench

REFUSED = "(refused)"
"""Stands for the analysis' refusal, where that is the answer to a break."""


@dataclass(frozen=True, kw_only=True)
class Break:
    """One way to break a rig."""

    name: str
    extent: str
    """From where to where it is drawn, evenly, in words."""
    apply: Callable[[Bench, Generator], Bench]
    seen_by: str = ""
    """The check that must detect it; empty if no check can."""
    unseen: str = ""
    """Why no check can detect it; empty if one can."""
    before_compensation: bool = False
    """The check needs the recordings only, so no method is run."""
    simulators: tuple[str, ...] = tuple(POPULATIONS)


def _both(bench: Bench, name: str, value: Value | str) -> Bench:
    return replace(
        bench, no_load={**bench.no_load, name: value}, loaded={**bench.loaded, name: value}
    )


def _loaded(bench: Bench, name: str, value: Value) -> Bench:
    return replace(bench, loaded={**bench.loaded, name: value})


def _signed(rng: Generator, low: float, high: float) -> float:
    return float(rng.uniform(low, high) * rng.choice([-1.0, 1.0]))


def _loose(bench: Bench, rng: Generator) -> Bench:
    slack = scaled(bench.no_load, NATURAL[bench.simulator], rng.uniform(0.6, 0.85))
    return replace(bench, no_load=slack, loaded=slack)


BREAKS = (
    Break(
        name="frequency entered wrong",
        extent="true one 1 to 5 % away, either way",
        apply=lambda bench, rng: _both(bench, "frequency_error", Value(_signed(rng, 1, 5), "%")),
        seen_by="entered frequency",
        before_compensation=True,
    ),
    Break(
        name="other eccentric",
        extent="stroke 3 to 8 % away, either way",
        apply=lambda bench, rng: _both(
            bench, "eccentric", Value(2 * (1 + _signed(rng, 0.03, 0.08)), "mm")
        ),
        seen_by="stroke",
        before_compensation=True,
    ),
    Break(
        name="clipping",
        extent="converter ends at 2 to 4 N·m",
        apply=lambda bench, rng: _both(bench, "sensors.range", Value(rng.uniform(2, 4), "N·m")),
        seen_by="clipping",
        before_compensation=True,
    ),
    Break(
        name="spikes",
        extent="0.2 to 2 % of the samples",
        apply=lambda bench, rng: _both(
            bench, "sensors.spike_probability", Value(rng.uniform(0.2, 2), "%")
        ),
        seen_by="spikes",
        before_compensation=True,
    ),
    Break(
        name="few cycles",
        extent="5 to 9",
        apply=lambda bench, rng: replace(bench, cycles=int(rng.integers(5, 10))),
        seen_by="cycles",
        before_compensation=True,
    ),
    Break(
        name="too few cycles",
        extent="1 to 4",
        apply=lambda bench, rng: replace(bench, cycles=int(rng.integers(1, 5))),
        seen_by=REFUSED,
        before_compensation=True,
    ),
    Break(
        name="slow sampling",
        extent="2 to 9 kHz",
        apply=lambda bench, rng: _both(
            bench, "sensors.rate", Value(round(rng.uniform(2000, 9000)), "Hz")
        ),
        seen_by="samples per cycle",
        before_compensation=True,
    ),
    Break(
        name="zero drift",
        extent="0.03 to 0.1 N·m between the runs, either way",
        apply=lambda bench, rng: replace(bench, zero_shift_nm=_signed(rng, 0.03, 0.1)),
        seen_by="zero drift",
        before_compensation=True,
    ),
    Break(
        name="load not there",
        extent="0 to 80 N in place of 1000 N",
        apply=lambda bench, rng: replace(bench, load_n=rng.uniform(0, 80)),
        seen_by="friction coefficient",
    ),
    Break(
        name="load in the wrong run",
        extent="1000 N in the no-load run, none in the loaded run",
        apply=lambda bench, _: replace(bench, no_load_n=LOAD_N, load_n=0.0),
        seen_by="torque above zero",
    ),
    Break(
        name="asymmetric offset",
        extent="0.1 to 0.3 N·m with the load, either way",
        apply=lambda bench, rng: replace(bench, one_sided_nm=_signed(rng, 0.1, 0.3)),
        seen_by="symmetry of the strokes",
    ),
    Break(
        name="inertia mismatch",
        extent="0.5 to 3 % between the runs, either way",
        apply=lambda bench, rng: replace(
            bench,
            loaded=with_inertia(bench.simulator, bench.loaded, 1 + _signed(rng, 0.005, 0.03)),
        ),
        seen_by="inertia of both runs",
    ),
    Break(
        name="loose coupling",
        extent="natural frequency 15 to 40 % down",
        apply=_loose,
        seen_by="coupling",
    ),
    Break(
        name="low-pass filter not as registered",
        extent="150 to 400 Hz in place of 1 kHz",
        apply=lambda bench, rng: _both(
            bench, "sensors.low_pass", Value(rng.uniform(150, 400), "Hz")
        ),
        seen_by="delay of the torque",
    ),
    Break(
        name="support friction grows with load",
        extent="by 2 to 10 %",
        apply=lambda bench, rng: replace(
            bench, loaded=scaled(bench.loaded, "support.friction", 1 + rng.uniform(0.02, 0.1))
        ),
        unseen="adds to the torque of every frequency just as the bearing's own does",
    ),
    Break(
        name="bearing friction at zero load",
        extent="that of 20 to 150 N",
        apply=lambda bench, rng: replace(bench, no_load_n=rng.uniform(20, 150)),
        unseen="cannot be told from the support's friction",
    ),
    Break(
        name="speed jitter",
        extent="0.05 to 0.3 % from turn to turn",
        apply=lambda bench, rng: _both(bench, "speed_jitter", Value(rng.uniform(0.05, 0.3), "%")),
        seen_by="steady speed",
        before_compensation=True,
    ),
    Break(
        name="torque behind angle",
        extent="0.2 to 1 ms in both runs",
        apply=lambda bench, rng: _both(
            bench, "sensors.torque_delay", Value(rng.uniform(0.2, 1), "ms")
        ),
        seen_by="delay of the torque",
    ),
    Break(
        name="torque behind angle under load",
        extent="0.05 to 0.3 ms in the loaded run only",
        apply=lambda bench, rng: _loaded(
            bench, "sensors.torque_delay", Value(rng.uniform(0.05, 0.3), "ms")
        ),
        seen_by="drive line under load",
    ),
    Break(
        name="other filter under load",
        extent="300 to 700 Hz in place of 1 kHz in the loaded run only",
        apply=lambda bench, rng: _loaded(
            bench, "sensors.low_pass", Value(rng.uniform(300, 700), "Hz")
        ),
        seen_by="drive line under load",
    ),
    Break(
        name="load off the swing's axis",
        extent="0.05 to 0.2 N·m at the swing's ends, either way",
        apply=lambda bench, rng: replace(bench, spring_nm=_signed(rng, 0.05, 0.2)),
        seen_by="torque that follows the angle",
    ),
    Break(
        name="encoder noise",
        extent="0.003 to 0.03° per sample",
        apply=lambda bench, rng: _both(
            bench, "sensors.encoder_noise", Value(rng.uniform(0.003, 0.03), "deg")
        ),
        unseen="harmless: frequency and phase are those of whole cycles",
    ),
    Break(
        name="Stribeck law",
        extent="weakening within 0.3 to 1 rad/s",
        apply=lambda bench, rng: _both(
            _both(bench, "bearing.weakening", "speed"),
            "bearing.stribeck_speed",
            Value(rng.uniform(0.3, 1.0), "rad/s"),
        ),
        unseen="no fault: another law of friction, which no method here presumes",
        simulators=("swing_tester_sim",),
    ),
)
