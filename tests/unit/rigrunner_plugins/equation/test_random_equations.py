"""200 random equations: value, u and degrees of freedom against GTC, k and coverage by trials.

GTC (Measurement Standards Laboratory of New Zealand) takes the text of each equation as Python,
with its own uncertain numbers; the trials are plain numpy, written here.
"""

from __future__ import annotations

import re
from math import inf, sqrt

import GTC
import numpy as np
import pytest

from helpers_thorough import examples
from rigrunner.signal.coverage import factor
from unit.rigrunner_plugins.equation.helpers_equation import findings, run_of

COUNT = 200
TRIALS = 40_000
SHAPES = ("normal", "rectangular", "triangular", "arcsine", "t")
HALF_WIDTH = {"rectangular": sqrt(3), "triangular": sqrt(6), "arcsine": sqrt(2)}


def formula(rng, names, depth):
    """Return a random formula whose functions are defined for every input, all from 1 to 3."""
    if depth == 0 or rng.random() < 0.15:
        return str(rng.choice(names)) if rng.random() < 0.85 else f"{rng.uniform(0.5, 3):.3f}"
    one, two = (formula(rng, names, depth - 1) for _ in range(2))
    return str(
        rng.choice(
            [f"({one} + {two})", f"({one} - {two})", f"({one})*({two})",
             f"({one})/(10 + ({two})**2)", f"sqrt(25 + ({one})**2)", f"exp(({one})/20)",
             f"log(30 + ({one})**2)", f"sin(({one})/10)", f"cos(({one})/10)", f"atan({one})",
             f"log10(40 + ({one})**2)", f"(3 + ({one})**2)**0.5", f"tan(({one})/100)"]
        )
    )  # fmt: skip


class Case:
    """An equation, what is known of its inputs, and both evaluations."""

    def __init__(self, seed, least_dof=3):
        rng = np.random.default_rng([2026, seed])
        names = ["x", "a", "b", "c"][: int(rng.integers(2, 5))]
        self.text = formula(rng, names, 3)
        self.text += "".join(
            f" + {name}/5" for name in names if not re.search(rf"\b{name}\b", self.text)
        )
        self.readings = rng.normal(
            rng.uniform(1, 3), rng.uniform(0.001, 0.02), rng.integers(1, 20) + least_dof
        )
        n = len(self.readings)
        x = (self.readings.mean(), self.readings.std(ddof=1) / sqrt(n), n - 1, "t")
        self.inputs = {"x": x}
        for name in names[1:]:
            shape = str(rng.choice(SHAPES))
            dof = float(rng.integers(0, 25) + least_dof) if shape == "t" else inf
            self.inputs[name] = (rng.uniform(1, 3), rng.uniform(0.0005, 0.01), dof, shape)

    def ours(self):
        constants = {}
        for name, (value, u, dof, shape) in self.inputs.items():
            if name == "x":
                continue
            constant = {"value": value, "u": u}
            if shape == "t":
                constant["degrees_of_freedom"] = dof
            elif shape in HALF_WIDTH:
                constant = {"value": value, "limits": u * HALF_WIDTH[shape], "distribution": shape}
            constants[name] = constant
        settings = {
            "result": {"name": "y", "unit": "1"}, "model": self.text, "second_order": "no",
            "inputs": {"x": {"of": "meter.ratio", "instrument": False}}, "constants": constants,
        }  # fmt: skip
        run = run_of({"meter.ratio": self.readings}, {"meter.ratio": "1"})
        return findings(settings, run).results[0].estimate

    def by_gtc(self):
        numbers = {name: GTC.ureal(v, u, dof) for name, (v, u, dof, _) in self.inputs.items()}
        functions = {name: getattr(GTC, name) for name in
                     ("sqrt", "exp", "log", "log10", "sin", "cos", "tan", "atan")}  # fmt: skip
        return eval(self.text, {"__builtins__": {}}, functions | numbers)  # noqa: S307  (made here)

    def by_trials(self):
        rng = np.random.default_rng(7)
        drawn = {}
        for name, (value, u, dof, shape) in self.inputs.items():
            unit = {
                "normal": lambda: rng.standard_normal(TRIALS),
                "t": lambda dof=dof: rng.standard_t(dof, TRIALS),
                "rectangular": lambda: sqrt(3) * rng.uniform(-1, 1, TRIALS),
                "triangular": lambda: sqrt(6) * (rng.uniform(-0.5, 0.5, (2, TRIALS)).sum(axis=0)),
                "arcsine": lambda: sqrt(2) * np.sin(rng.uniform(-np.pi, np.pi, TRIALS)),
            }[shape]
            drawn[name] = value + u * unit()
        functions = {name: getattr(np, name) for name in
                     ("sqrt", "exp", "log", "log10", "sin", "cos", "tan")}  # fmt: skip
        functions["atan"] = np.arctan
        return np.broadcast_to(
            eval(self.text, {"__builtins__": {}}, functions | drawn), TRIALS  # noqa: S307
        )  # fmt: skip


def test_value_u_and_degrees_of_freedom_equal_those_of_gtc():
    for case in map(Case, range(examples(COUNT))):
        ours, y = case.ours(), case.by_gtc()
        assert ours.value == pytest.approx(y.x, rel=1e-12), case.text
        assert ours.u == pytest.approx(y.u, rel=1e-11), case.text
        if y.u > 1e-12:
            assert min(ours.dof, 1e6) == pytest.approx(min(y.df, 1e6), rel=1e-6), case.text


@pytest.mark.thorough
def test_interval_covers_95_percent():
    """y ± k u covers 95 % of plain trials, with k of the shape of the sum.

    From 30 degrees of freedom on: with fewer, trials of a scaled t are wider than by Welch and
    Satterthwaite (JCGM 101:2008, 5.11.2). A shape flatter than a rectangle, such as an arcsine,
    counts as a rectangle: the interval is then too wide.
    """
    shares, ks = [], []
    for seed in range(COUNT):
        case = Case(seed, least_dof=30)
        ours = case.ours()
        if ours.u < 1e-12:
            continue
        k = factor(ours)
        away = np.abs(case.by_trials() - ours.value) / ours.u
        share, by_trials = np.mean(away <= k), np.quantile(away, 0.95)
        ks.append(k)
        if ours.kurtosis >= -1.2:
            shares.append(share)
            assert k == pytest.approx(by_trials, rel=0.03), case.text
            assert share == pytest.approx(0.95, abs=0.01), case.text
        else:
            assert by_trials / k < 1.02, case.text
            assert share > 0.945, case.text
    assert len(shares) > 0.8 * COUNT
    assert np.mean(shares) == pytest.approx(0.95, abs=0.002)
    assert min(ks) < 1.66  # nearly one rectangle
    assert max(ks) > 1.99  # few degrees of freedom
