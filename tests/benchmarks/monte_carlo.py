"""Monte Carlo: trials of a measurement equation, and draws of the recorded data.

A million trials by the adaptive procedure (JCGM 101), in blocks, with mean, standard uncertainty
and both coverage intervals at the end. The floor only draws the same random numbers in the same
blocks. The first equation has four correlated Gaussian inputs; the other is that of the
demonstration's result, the mean of twelve set-points. A draw of the pipeline perturbs the cycles of
the demonstration and its rig, and compensates them again; its floor is one analysis of both runs,
without reading them.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.frame import Figure, Work, allocated_peak, at_least, at_most, calls, paired
from helpers_workflow import run
from rigrunner.api.uncertainty import Input, MeasurementModel
from rigrunner.clock import SimulatedClock
from rigrunner.procedure import parse_procedure
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure
from rigrunner.run.stored import analyse_stored, read
from rigrunner.signal.monte_carlo.adaptive import BLOCK, Adaptive, propagate
from rigrunner.signal.monte_carlo.distributions import MultivariateT
from rigrunner.signal.monte_carlo.model import _grouped_inputs, output_of
from rigrunner_bearings.api.compensations import Sweep
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.signal.mean_model import mean_model
from rigrunner_bearings.torque.analysis import with_known_load
from rigrunner_bearings.torque.draws import draw_pipeline
from rigrunner_bearings.torque.settings import SwingTorque

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator

    from benchmarks.frame import Scale, Target
    from rigrunner.api.results import Result
    from rigrunner.runfile import StoredRun
    from rigrunner.signal.monte_carlo.distributions import Distribution

TRIALS = 1_000_000
MEGA = 1e6
NAMES = "abcd"
CORRELATION = np.array(
    [[1.0, 0.5, 0.2, 0.0], [0.5, 1.0, 0.3, 0.1], [0.2, 0.3, 1.0, 0.4], [0.0, 0.1, 0.4, 1.0]]
)
HALF, FOUR_FIFTHS = at_least(0.5), at_least(0.8)
LIMIT = "the equation and its correlations, then the values of both intervals"


def four_correlated() -> MeasurementModel:
    inputs = tuple(Input(name, 1.0 + i, 0.01) for i, name in enumerate(NAMES))
    return MeasurementModel(inputs, lambda x: x["a"] * x["b"] / x["c"] + x["d"], CORRELATION)


def trials(model: MeasurementModel, count: int) -> None:
    propagate(output_of(model), Adaptive(least_trials=count, most_trials=count))


def draw_numbers(draws: list[Callable[[Generator], object]], count: int) -> None:
    """Draw the random numbers of the trials, in the same blocks."""
    for block in range(count // BLOCK):
        rng = np.random.default_rng(np.random.SeedSequence(1, spawn_key=(block,)))
        for draw in draws:
            draw(rng)


def generator_calls(model: MeasurementModel) -> list[Callable[[Generator], object]]:
    """Return the calls of numpy's generator for the inputs of a model."""
    independent, groups = _grouped_inputs(model)
    joint = (_joint(distribution, len(group)) for group, distribution in groups)
    return [*map(_independent, independent), *joint]


def _independent(quantity: Input) -> Callable[[Generator], object]:
    if quantity.distribution == "rectangular":
        return lambda rng: rng.uniform(-1, 1, BLOCK)
    if quantity.dof == inf:
        return lambda rng: rng.standard_normal(BLOCK)
    return lambda rng: rng.standard_t(quantity.dof, BLOCK)


def _joint(distribution: Distribution, size: int) -> Callable[[Generator], object]:
    if isinstance(distribution, MultivariateT):
        dof = distribution.dof
        return lambda rng: (rng.chisquare(dof, BLOCK), rng.standard_normal((BLOCK, size)))
    return lambda rng: rng.standard_normal((BLOCK, size))


def simple_script(count: int) -> None:
    """Do all trials at once, as a short script would: Cholesky, quantiles."""
    rng = np.random.default_rng(1)
    factor = np.linalg.cholesky(CORRELATION * 0.01**2)
    a, b, c, d = ([1.0, 2.0, 3.0, 4.0] + rng.standard_normal((count, 4)) @ factor.T).T
    y = a * b / c + d
    y.mean(), y.std(ddof=1), np.quantile(y, [0.025, 0.975])


@dataclass(frozen=True)
class Demo:
    """The loaded run of the demonstration, and its result."""

    stored: StoredRun
    result: Result

    @property
    def model(self) -> MeasurementModel:
        torque = TorqueDetails.of(self.result)
        return mean_model(torque.compensations[torque.primary].points)

    def analyse(self) -> None:
        analyse_stored(self.stored, load_registry())

    def draw(self, draws: int) -> None:
        registry, result = load_registry(), self.result
        torque = TorqueDetails.of(result)
        text, name = self.stored.header.procedure_text, self.stored.header.procedure_id
        (instrument,) = result.run.instruments.values()
        loads = [point.load_n for point in torque.loaded]
        rig = with_known_load(result.run, instrument.channel, loads)
        (settings,) = parse_procedure(text, name).model.analysis
        method = SwingTorque.model_validate(settings.settings).primary_plugin
        draw_pipeline(
            registry.make("compensation", method.name, method.settings),
            Sweep(torque.loaded, torque.no_load, rig, instrument, lambda _: None),
            torque.compensations[torque.primary].points,
            zeroed=True,
            draws=draws,
            seed=1,
            progress=lambda *_: None,
        )


def demo() -> Demo:
    with tempfile.TemporaryDirectory() as name:
        folder, clock = Path(name), SimulatedClock()
        for procedure in ("no_load_inertia_sweep", "starting_torque_1000n"):
            finished = run(find_procedure(procedure), folder / "runs", clock=clock)
        return Demo(read(finished.folder), finished.result)


def measure(scale: Scale) -> list[Figure]:
    count, times = scale.of(TRIALS, 2 * BLOCK), scale.of(15, 1)
    correlated = rates("4 correlated inputs", four_correlated(), count, times, FOUR_FIFTHS)
    figures = [*correlated, plain(count, times)]
    return figures if scale.short else [*figures, *demonstration_figures(demo(), count)]


def demonstration_figures(demonstration: Demo, count: int, times: int = 7) -> list[Figure]:
    equation = rates("the demonstration's equation", demonstration.model, count, times)
    return [*equation, *pipeline(demonstration, times)]


def rates(
    what: str, model: MeasurementModel, count: int, times: int, target: Target = HALF
) -> list[Figure]:
    pair = paired(
        partial(trials, model, count), partial(draw_numbers, generator_calls(model), count), times
    )
    label, unit = f"{what} ({len(model.inputs)})", "M trials/s"
    return [
        Figure(f"random numbers of {label}", pair.floor.rate(count / MEGA), unit, "floor"),
        Figure(
            f"trials of {label}",
            pair.ours.rate(count / MEGA),
            unit,
            ratio=pair.speed,
            target=target,
            note=LIMIT,
        ),
    ]


def plain(count: int, times: int) -> Figure:
    model = four_correlated()
    pair = paired(partial(trials, model, count), partial(simple_script, count), times)
    note = "ratio: ours against it; one interval, no blocks, no check that it settled"
    rate = pair.floor.rate(count / MEGA)
    return Figure("plain numpy, all at once", rate, "M trials/s", "peer", pair.speed, note=note)


def pipeline(demonstration: Demo, times: int) -> list[Figure]:
    pair = paired(partial(demonstration.draw, 1), demonstration.analyse, times)
    return [
        Figure("one analysis of the demonstration", pair.floor, "s", "floor"),
        Figure(
            "one draw of its pipeline",
            pair.ours,
            "s",
            ratio=pair.ratio,
            target=at_most(3.0),
            note="the method itself, twelve set-points in two runs",
        ),
    ]


def work() -> list[Work]:
    model, few, many = four_correlated(), 10 * BLOCK, 20 * BLOCK
    once, twice = (calls(partial(trials, model, count)) for count in (few, many))
    normals: list[int] = []

    def counting(rng: Generator, n: int) -> np.ndarray:
        normals.append(n)
        return rng.standard_normal(n)

    propagate(counting, Adaptive(least_trials=few, most_trials=few))
    peak = allocated_peak(partial(trials, model, many))
    return [
        Work("calls of functions for each block", (twice - once) / 10, 200),
        Work("trials drawn for each one that counts", sum(normals) / few, 1),
        Work("bytes held for each trial", peak / many, 40),
    ]
