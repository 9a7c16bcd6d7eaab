"""The analysis `equation`: results of a measurement model, by the GUM and by Monte Carlo.

One tree serves the law of propagation (GUM 5.1.2 and 5.2.2), its terms of second order, and the
trials of JCGM 101, which say whether the interval of the GUM holds what it claims.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, isfinite, isnan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import Check, Component
from rigrunner.api.errors import DataError
from rigrunner.api.findings import Findings, MeasurementResult
from rigrunner.api.uncertainty import Corrected, Differentiable
from rigrunner.api.uncertainty import Effect as ToFirstOrder
from rigrunner.signal.coverage import expanded
from rigrunner.signal.monte_carlo.intervals import numerical_tolerance, symmetric
from rigrunner.signal.monte_carlo.model import output_of
from rigrunner.signal.propagation import propagate, sensitivities
from rigrunner_plugins.analyses.equation.model import inputs_of
from rigrunner_plugins.analyses.equation.second_order import added_variance
from rigrunner_plugins.analyses.sources import groups

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.data import Array, Estimate, RunData
    from rigrunner.api.findings import ResultDefinition
    from rigrunner.api.uncertainty import MeasurementModel
    from rigrunner_plugins.analyses.equation.settings import EquationSettings
    from rigrunner_plugins.analyses.sources import Group

CURVATURE = "curvature of the model (second order)"
TRIALS = 50_000
SEED = 1
MOST_TRIED = 30
"""So many places are tried by Monte Carlo, spread evenly over all."""
MOST_MISSED = 0.02
"""Of the trials, beyond y ± U by the curvature of the model: more, and U claims too much."""
DIGITS = 2


@dataclass(frozen=True, eq=False)
class Trial:
    """What the trials of one result say."""

    mean: float
    u: float
    low: float
    high: float
    held: float
    """Which share of them is within y ± U."""
    held_if_straight: float
    """The same of the model's tangent: what it is less comes from the model's curvature."""
    lost: int
    """How many gave no number."""


@dataclass(frozen=True, eq=False)
class Evaluated:
    """A result, the model that it follows from, and what trials of it say."""

    result: MeasurementResult
    model: MeasurementModel
    first_order_u: float
    added: float
    """Variance that the terms of second order add, in the unit of the result, squared."""

    @cached_property
    def trial(self) -> Trial | None:
        """By Monte Carlo; None where an uncertainty is unknown, or there is none."""
        estimate = self.result.estimate
        if isnan(estimate.u) or not estimate.u:
            return None
        values, straight = (
            output_of(model)(np.random.default_rng(SEED), TRIALS)
            for model in (self.model, self._tangent)
        )
        good = np.sort(values[np.isfinite(values)])
        if len(good) < TRIALS / 2:
            raise DataError(f"the model of {self.result.name} has no value in most of its trials")
        interval = symmetric(good, 0.95)
        reach = expanded(estimate)
        return Trial(
            mean=float(good.mean()),
            u=float(good.std(ddof=1)),
            low=interval.low,
            high=interval.high,
            held=float(np.sum(np.abs(good - estimate.value) <= reach)) / TRIALS,
            held_if_straight=float(np.mean(np.abs(straight - estimate.value) <= reach)),
            lost=TRIALS - len(good),
        )

    @property
    def _tangent(self) -> MeasurementModel:
        """The model of first order, of the same inputs."""
        slopes = sensitivities(self.model)
        effects = tuple(
            ToFirstOrder(each, float(c)) for each, c in zip(self.model.inputs, slopes, strict=True)
        )
        return replace(self.model, equation=Corrected(self.model.value, effects))


@dataclass(frozen=True)
class EquationAnalysis:
    """Satisfies `rigrunner.api.findings.Analysis`."""

    settings: EquationSettings

    def __call__(self, run: RunData) -> Findings:
        """Return the results at each place; raise DataError where the model has no value."""
        settings = self.settings
        names = [str(each.of) for each in settings.inputs.values()]
        found = groups(run, names, per=settings.per, where=settings.where, table=settings.table)
        definitions = settings.yields()
        by_place = [self._at(run, group, definitions) for group in found]
        evaluated = [each for place in by_place for each in place]
        order = [
            each for name in range(len(definitions)) for each in evaluated[name :: len(definitions)]
        ]
        return Findings(
            results=tuple(each.result for each in order),
            checks=tuple(_checks(order)),
            notes=tuple(_notes(settings, order)),
        )

    def _at(
        self, run: RunData, group: Group, definitions: Sequence[ResultDefinition]
    ) -> list[Evaluated]:
        inputs = inputs_of(run, self.settings, group)
        return [
            self._evaluated(inputs.model(self.settings, told), definition, group)
            for told, definition in zip(self.settings.all_results, definitions, strict=True)
        ]

    def _evaluated(
        self, model: MeasurementModel, definition: ResultDefinition, group: Group
    ) -> Evaluated:
        value = model.value
        if not isfinite(value):
            place = ", ".join(f"{name} = {each}" for name, each in group.place.items())
            raise DataError(
                f"the model of {definition.name} has no value{f' at {place}' if place else ''}",
                hint="a divisor is 0, or a function is not defined there",
            )
        try:
            found = propagate(model)
        except ValueError as error:
            raise DataError(f"{definition.name}: {error}") from error
        components = tuple(_in_unit(model, each, definition.unit) for each in found.components)
        estimate = replace(found.estimate, unit=definition.unit)
        added = self._added(model, estimate)
        if added > 0:
            estimate = _widened(estimate, added)
            components += (_curvature(added, definition.unit),)
        result = MeasurementResult(
            of=definition,
            estimate=estimate,
            components=components,
            coordinates=group.place,
            readings=len(group.times_s),
        )
        return Evaluated(result, model, found.estimate.u, added)

    def _added(self, model: MeasurementModel, estimate: Estimate) -> float:
        """Return the variance of second order that enters; 0 where it does not matter."""
        equation = model.equation
        if self.settings.second_order is False or isnan(estimate.u):
            return 0.0
        assert isinstance(equation, Differentiable)  # noqa: S101  (a Tree)
        added = added_variance(model, equation)
        whole = sqrt(max(estimate.u**2 + added, 0.0))
        matters = abs(whole - estimate.u) > numerical_tolerance(estimate.u, DIGITS)
        return added if self.settings.second_order or matters else 0.0


def _in_unit(model: MeasurementModel, component: Component, symbol: str) -> Component:
    """Return a line of several inputs with the unit of the result, in which it stands whole."""
    several = sum(each.budget_line == component.name for each in model.inputs) > 1
    return replace(component, unit=symbol) if several else component


def _widened(estimate: Estimate, added: float) -> Estimate:
    u = sqrt(estimate.u**2 + added)
    share = (estimate.u / u) ** 4
    dof = estimate.dof / share if share > 0 else inf
    return replace(estimate, u=u, dof=dof, kurtosis=estimate.kurtosis * share)


def _curvature(added: float, symbol: str) -> Component:
    u = sqrt(added)
    return Component(CURVATURE, u, inf, "normal", common=False, unit=symbol, input_u=u,
                     sensitivity=1.0)  # fmt: skip


def tried(found: Sequence[Evaluated]) -> list[Evaluated]:
    """Return the results that are tried by Monte Carlo: all, or some that are spread evenly."""
    if len(found) <= MOST_TRIED:
        return list(found)
    places = np.linspace(0, len(found) - 1, MOST_TRIED).round().astype(int)
    return [found[place] for place in places]


def _checks(found: Sequence[Evaluated]) -> Iterator[Check]:
    """Yield, for each result, whether y ± U holds the trials that it claims to hold."""
    names = dict.fromkeys(each.result.name for each in found)
    for name in names:
        trials = [
            (each, each.trial)
            for each in tried([one for one in found if one.result.name == name])
            if each.trial is not None
        ]
        if not trials:
            continue
        worst, trial = max(trials, key=lambda pair: _missed(pair[1]))
        ok = _missed(trial) <= MOST_MISSED
        place = f" at {worst.result.place}" if worst.result.place else ""
        lost = f"; {trial.lost} of {TRIALS} trials have no value" if trial.lost else ""
        text = (
            f"y ± U holds {100 * trial.held:.0f} % of the trials{place}, and would hold"
            f" {100 * trial.held_if_straight:.0f} % if the model were straight{lost}"
        )
        advice = "the model is too curved for these inputs: measure them better"
        yield Check(
            f"Monte Carlo of {name}",
            ok=ok,
            text=text,
            advice="" if ok else advice,
            value=_missed(trial),
            threshold=MOST_MISSED,
            unit="1",
            decisive=True,
        )


def _missed(trial: Trial) -> float:
    """Return which share of the trials y ± U misses by the curvature of the model."""
    return max(trial.held_if_straight - trial.held, 0.0)


def _notes(settings: EquationSettings, found: Sequence[Evaluated]) -> Iterator[str]:
    bent = [each for each in found if each.added > 0]
    for name in dict.fromkeys(each.result.name for each in bent):
        most = max((each for each in bent if each.result.name == name), key=lambda each: each.added)
        u = most.result.estimate.u
        yield (
            f"{name}: the curvature of the model counts: u is {u:.2g} {most.result.of.unit} with"
            f" the terms of second order (GUM 5.1.2, note), and {most.first_order_u:.2g} without."
        )
    for name, told in settings.inputs.items():
        if not told.instrument:
            yield (
                f"{name}: what the register says of {told.of} is not used; its errors are among the"
                " constants, or left out."
            )
    if any(each.result.readings == 1 for each in found) and any(
        each.scatter is None for each in settings.inputs.values()
    ):
        yield (
            f"{found[0].result.name}: a value is a single reading, which shows no scatter: its"
            " uncertainty is the instrument's alone."
        )


def correlation(one: Evaluated, other: Evaluated) -> float:
    """Return the correlation coefficient of two results of the same inputs (GUM 5.2, H.2)."""
    u = np.array([each.u for each in one.model.inputs])
    r: Array = np.eye(len(u)) if one.model.correlation is None else one.model.correlation
    a, b = sensitivities(one.model) * u, sensitivities(other.model) * u
    whole = sqrt(float(a @ r @ a) * float(b @ r @ b))
    return float(a @ r @ b) / whole if whole else 0.0
