"""Random rigs, healthy or with a fault; each has a pair of runs.

A seed names a rig. What is drawn of a healthy one stays within what its station states, except for
the friction of the support under load, which is drawn within what a spindle bearing may do.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from other_physics.chain import Chain
from other_physics.model import Rig

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator

LOAD_N = 1000.0
KNOWN_NM = 0.012
"""Starting torque of a rolling bearing with which the support is measured under load."""
FREQUENCIES_HZ = (1.0, 3.0, 5.0, 8.0, 10.0, 15.0, 18.0, 20.0, 25.0, 30.0, 33.0, 35.0)


@dataclass(frozen=True)
class Run:
    """One run: the rig, the chain and the warming during the run."""

    rig: Rig
    chain: Chain
    load_n: float
    """The actual load."""
    warming: float = 0.0
    """The part by which the support's friction is greater when it is cold."""
    warming_s: float = 600.0
    begun_s: float = 0.0
    """When its first recording begins, after the set-up."""


@dataclass(frozen=True)
class Pair:
    """Both runs on one rig, and how they were recorded."""

    seed: int
    no_load: Run
    loaded: Run
    cycles: int = 20
    cycles_of_slow: int = 10
    """Below 5 Hz."""
    group: str = "healthy"
    size: str = ""
    """Of the fault, with its unit."""
    frequencies_hz: tuple[float, ...] = FREQUENCIES_HZ


@dataclass(frozen=True)
class Group:
    """A fault: its name, the range of its size, and its effect on a healthy pair."""

    name: str
    low: float
    high: float
    unit: str
    apply: Callable[[Pair, float], Pair] = field(repr=False)


def healthy(seed: int, recording_gain: float = 0.002) -> Pair:
    """Return a rig without a fault; its gain scatters from recording to recording."""
    rng = np.random.default_rng([seed, 1])
    rig = _rig(rng)
    chain = _chain(rng)._replace(recording_gain=recording_gain)
    warming = rng.uniform(0.0, 0.01)
    growth = rng.uniform(0.0, 0.015)
    free = rig._replace(bearing_kinetic_nm=0.0, bearing_static_nm=0.0)
    under_load = _scaled(rig, growth, "support_coulomb_nm", "support_static_nm")
    pause_s = rng.uniform(300.0, 1200.0)
    return Pair(
        seed,
        no_load=Run(free, chain, 0.0, warming),
        loaded=Run(under_load, chain, LOAD_N, warming, begun_s=pause_s + 120.0),
    )


def faulty(group: Group, seed: int) -> Pair:
    """Return a rig with that fault; its size is drawn with the seed."""
    size = _size(group, seed)
    size_text = f"{size:.3g} {group.unit}" if group.unit != "1" else f"{size:.2%}"
    return replace(group.apply(healthy(seed), size), group=group.name, size=size_text)


def run_after(pair: Pair) -> Run:
    """Return a no-load run after the loaded one.

    A support that became warmer or colder changes further, by up to the same amount, and a changed
    gain stays changed. Effects of the load or of the bearing disappear with it.
    """
    rng = np.random.default_rng([pair.seed, 6])
    begun_s = pair.loaded.begun_s + _DURATION_S + rng.uniform(300.0, 1200.0)
    run, further = replace(pair.no_load, begun_s=begun_s), rng.uniform(1.0, 2.0)
    group = next((fault for fault in FAULTS if fault.name == pair.group), None)
    if group is None:
        return run
    if group.apply is _warmer:
        return replace(run, rig=_scaled(run.rig, further * _size(group, pair.seed), *_FRICTION))
    return replace(run, chain=pair.loaded.chain) if group.apply is _gain_step else run


def known_bearing(pair: Pair) -> Pair:
    """Return the pair with another bearing, of little and known friction."""
    share = KNOWN_NM / pair.loaded.rig.bearing_static_nm
    names = ("bearing_kinetic_nm", "bearing_static_nm", "bearing_bristle")
    return _loaded_rig(pair, share - 1.0, *names)


def _size(group: Group, seed: int) -> float:
    return float(np.random.default_rng([seed, 2]).uniform(group.low, group.high))


def _rig(rng: Generator) -> Rig:
    kinetic = rng.uniform(0.4, 1.0)
    natural = rng.uniform(0.35, 0.95)  # of both stiffnesses: 240 to 395 Hz, as 10 kHz resolves
    coulomb = 0.72 * rng.uniform(0.7, 1.2)
    return Rig(
        ripple_1=rng.uniform(0.0, 0.004),
        ripple_1_phase=rng.uniform(0.0, 2.0 * np.pi),
        ripple_2=rng.uniform(0.0, 0.002),
        ripple_2_phase=rng.uniform(0.0, 2.0 * np.pi),
        stroke_modulation=rng.uniform(0.0, 0.0005),
        gauge_stiffness=60e3 * natural,
        coupling_stiffness=19.5e3 * natural,
        coupling_damping=0.55 * rng.uniform(0.6, 1.6),
        spindle_inertia=2.25e-3 * rng.uniform(0.85, 1.2),
        support_coulomb_nm=coulomb,
        support_static_nm=coulomb * rng.uniform(1.0, 1.15),
        support_bristle=260.0 * rng.uniform(0.7, 1.5),
        support_viscous=0.30 * rng.uniform(0.6, 1.4),
        bearing_kinetic_nm=kinetic,
        bearing_static_nm=kinetic * rng.uniform(1.02, 1.3),
        bearing_stribeck_rad_s=rng.uniform(0.3, 3.0),
        bearing_bristle=450.0 * rng.uniform(0.7, 2.0),
        is_iwan=bool(rng.uniform() < 0.4),
        iwan_spread=rng.uniform(2.0, 8.0),
        housing_stiffness=rng.uniform(15e3, 100e3),
    )


def _chain(rng: Generator) -> Chain:
    """Return errors within the register: gain 0.3 %, zero and drift 0.02 N.m, 0.05 % of scale."""
    return Chain(
        gain=rng.uniform(-0.003, 0.003),
        cubic=rng.uniform(-0.0005, 0.0005),
        hysteresis=rng.uniform(0.0, 0.0005),
        zero_nm=rng.uniform(-0.02, 0.02),
        drift_nm=rng.uniform(-0.02, 0.02),
        hum_nm=rng.uniform(0.0, 0.01),
        hum_hz=rng.uniform(49.9, 50.1),
        low_pass_hz=1000.0 * rng.uniform(0.98, 1.02),
        noise_nm=rng.uniform(0.01, 0.03),
        encoder_noise_rad=np.radians(rng.uniform(0.0, 0.003)),
    )


def _scaled(rig: Rig, growth: float, *names: str) -> Rig:
    """Return the rig with some of its parameters increased in proportion."""
    return rig._replace(**{name: getattr(rig, name) * (1.0 + growth) for name in names})


def _loaded_rig(pair: Pair, growth: float, *names: str) -> Pair:
    return replace(pair, loaded=replace(pair.loaded, rig=_scaled(pair.loaded.rig, growth, *names)))


def _both_rigs(pair: Pair, **parameters: float) -> Pair:
    return replace(
        pair,
        no_load=replace(pair.no_load, rig=pair.no_load.rig._replace(**parameters)),
        loaded=replace(pair.loaded, rig=pair.loaded.rig._replace(**parameters)),
    )


def _both_chains(pair: Pair, **parameters: float) -> Pair:
    return replace(
        pair,
        no_load=replace(pair.no_load, chain=pair.no_load.chain._replace(**parameters)),
        loaded=replace(pair.loaded, chain=pair.loaded.chain._replace(**parameters)),
    )


def _loaded_chain(pair: Pair, **parameters: float) -> Pair:
    return replace(
        pair, loaded=replace(pair.loaded, chain=pair.loaded.chain._replace(**parameters))
    )


def _left_load(pair: Pair, load_n: float) -> Pair:
    share, bearing = load_n / LOAD_N, pair.loaded.rig
    rig = pair.no_load.rig._replace(
        bearing_kinetic_nm=bearing.bearing_kinetic_nm * share,
        bearing_static_nm=bearing.bearing_static_nm * share,
        bearing_bristle=bearing.bearing_bristle * share,
    )
    return replace(pair, no_load=replace(pair.no_load, rig=rig, load_n=load_n))


def _gain_step(pair: Pair, size: float) -> Pair:
    gain = pair.loaded.chain.gain
    return _loaded_chain(pair, gain=(1.0 + gain) * (1.0 + size) - 1.0)


def _warmer(pair: Pair, size: float) -> Pair:
    return _loaded_rig(pair, size, *_FRICTION)


_FRICTION = ("support_coulomb_nm", "support_static_nm")
_DURATION_S = 130.0
"""How long a run takes."""

FAULTS = (
    Group("inertia changed", 0.002, 0.08, "1", lambda p, s: _loaded_rig(p, s, "spindle_inertia")),
    Group("inertia less", -0.08, -0.002, "1", lambda p, s: _loaded_rig(p, s, "spindle_inertia")),
    Group("viscosity under load", 0.1, 1.0, "1", lambda p, s: _loaded_rig(p, s, "support_viscous")),
    Group("support friction warmer", -0.10, -0.03, "1", _warmer),
    Group("support friction colder", 0.03, 0.10, "1", _warmer),
    Group("support slip", 0.2, 1.5, "1", lambda p, s: _loaded_rig(p, s, "support_bristle")),
    Group("support stiction", 0.05, 0.3, "1", lambda p, s: _loaded_rig(p, s, "support_static_nm")),
    Group("load left", 10.0, 60.0, "N", _left_load),
    Group("gain changed", 0.0005, 0.003, "1", _gain_step),
    Group("gain changed much", -0.03, -0.003, "1", _gain_step),
    Group("gain scatters", 0.004, 0.02, "1", lambda p, s: _both_chains(p, recording_gain=s)),
    Group("saturation", 3.0, 6.0, "N·m", lambda p, s: _both_chains(p, range_nm=s)),
    Group("saturation under load", 3.0, 6.0, "N·m", lambda p, s: _loaded_chain(p, range_nm=s)),
    Group("play", 0.0002, 0.003, "rad", lambda p, s: _both_rigs(p, play_rad=s)),
    Group(
        "play under load",
        0.0002,
        0.003,
        "rad",
        lambda p, s: replace(p, loaded=replace(p.loaded, rig=p.loaded.rig._replace(play_rad=s))),
    ),
    Group("coupling softer", -0.5, -0.1, "1", lambda p, s: _loaded_rig(p, s, "coupling_stiffness")),
    Group("damping", 0.5, 3.0, "1", lambda p, s: _loaded_rig(p, s, "coupling_damping")),
    Group("filter lower", 200.0, 700.0, "Hz", lambda p, s: _both_chains(p, low_pass_hz=s)),
    Group("filter under load", 200.0, 700.0, "Hz", lambda p, s: _loaded_chain(p, low_pass_hz=s)),
    Group("hum", 0.05, 0.3, "N·m", lambda p, s: _both_chains(p, hum_nm=s)),
    Group("noise", 0.08, 0.3, "N·m", lambda p, s: _both_chains(p, noise_nm=s)),
    Group("drift", 0.05, 0.3, "N·m", lambda p, s: _both_chains(p, drift_nm=s)),
    Group("hysteresis", 0.002, 0.01, "1", lambda p, s: _both_chains(p, hysteresis=s)),
    Group("non-linearity", 0.002, 0.01, "1", lambda p, s: _both_chains(p, cubic=s)),
    Group("torque lags", 5e-5, 5e-4, "s", lambda p, s: _both_chains(p, torque_lag_s=s)),
    Group("lags under load", 5e-5, 5e-4, "s", lambda p, s: _loaded_chain(p, torque_lag_s=s)),
    Group("ripple", 0.01, 0.05, "1", lambda p, s: _both_rigs(p, ripple_1=s)),
    Group("stroke modulated", 0.002, 0.02, "1", lambda p, s: _both_rigs(p, stroke_modulation=s)),
)
