"""A measurement model of ten inputs, as text in a procedure: the GUM, and Monte Carlo trials.

The GUM: value, sensitivities, uncertainty and budget of the analysis `equation`, after a first
evaluation and without the parsing of the model; some of the ten inputs have few degrees of freedom,
and two are rectangular. The trials are a million by the adaptive procedure (JCGM 101); their floor
draws the same random numbers in the same blocks.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import inf
from typing import TYPE_CHECKING

from benchmarks.frame import Figure, Work, at_most, calls, repeated
from benchmarks.monte_carlo import BLOCK, TRIALS, rates, trials
from rigrunner.api.uncertainty import Input, MeasurementModel
from rigrunner.signal.propagation import propagate
from rigrunner_plugins.analyses.equation.text import read
from rigrunner_plugins.analyses.equation.tree import Tree

if TYPE_CHECKING:
    from benchmarks.frame import Scale

TEXT = """\
area = pi * (d / 2)^2
stress = force * (1 + gain) / area
strain = (length - before - drift) / before
y = stress / strain * (1 - 2 * ratio * tilt) * exp(-slope * (warm - 20))
"""
ROUNDS = 200


def ten_inputs() -> MeasurementModel:
    """Return Young's modulus from a tensile test, in SI units."""
    inputs = (
        Input("d", 0.01, 1e-6, 9.0),
        Input("force", 1000.0, 1.0),
        Input("gain", 0.0, 1e-3, distribution="rectangular"),
        Input("length", 0.1001, 1e-7, 4.0),
        Input("before", 0.1, 1e-7),
        Input("drift", 0.0, 1e-8),
        Input("ratio", 0.3, 0.01),
        Input("tilt", 0.001, 2e-4, distribution="rectangular"),
        Input("slope", 3e-4, 1e-5, inf),
        Input("warm", 21.0, 0.2),
    )
    model = read(TEXT, [quantity.name for quantity in inputs], ["y"])
    return MeasurementModel(inputs, Tree(model, "y", {}, {}, 1.0, 0.0))


def gum(model: MeasurementModel) -> None:
    """Propagate the uncertainties of a new copy of a model, as in each place of a run."""
    propagate(replace(model))


def measure(scale: Scale) -> list[Figure]:
    model, times = ten_inputs(), scale.of(15, 1)
    gum(model)
    spread = repeated(lambda: [gum(model) for _ in range(ROUNDS)], times)
    row = Figure("GUM of ten inputs", spread.per(1e-3 * ROUNDS), "ms", target=at_most(1, "ms"))
    return [row, *rates("ten inputs", model, scale.of(TRIALS, 2 * BLOCK), times)]


def work() -> list[Work]:
    model, few, many = ten_inputs(), 10 * BLOCK, 20 * BLOCK
    gum(model)
    once, twice = (calls(partial(trials, model, count)) for count in (few, many))
    return [
        Work("calls of functions for the GUM", calls(partial(gum, model)), 5000),
        Work("calls of functions for each block of trials", (twice - once) / 10, 600),
    ]
