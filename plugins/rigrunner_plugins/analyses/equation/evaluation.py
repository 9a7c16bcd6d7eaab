"""The analysis `equation`: evaluates a measurement model by the GUM and by Monte Carlo.

One expression tree serves the law of propagation (GUM 5.1.2 and 5.2.2), its second-order terms, and
the trials of JCGM 101, which check the coverage of the GUM interval.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite, isnan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Check, Component, DataError, Findings, MeasurementResult, unit
from rigrunner.api.findings import MissingResult, ResultPlace
from rigrunner.api.units import si_symbol
from rigrunner.signal.monte_carlo.intervals import numerical_tolerance
from rigrunner.signal.propagation import propagate, sensitivities
from rigrunner_plugins.analyses.equation.evaluated import (
    MOST_TRIED,
    TRIALS,
    Evaluated,
    Trial,
    names_of,
    tried,
)
from rigrunner_plugins.analyses.equation.inputs import SEVERAL, CorrelationError
from rigrunner_plugins.analyses.equation.model import inputs_of
from rigrunner_plugins.analyses.equation.results import (
    groups_of_results,
    missing_results,
    results_at,
)
from rigrunner_plugins.analyses.equation.second_order import added_variance
from rigrunner_plugins.analyses.equation.shown import both_methods, formulas, tables
from rigrunner_plugins.analyses.sources import groups, is_read

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Estimate, MeasurementModel, ResultDefinition, RunData
    from rigrunner_plugins.analyses.equation.inputs import Inputs
    from rigrunner_plugins.analyses.equation.settings import EquationSettings
    from rigrunner_plugins.analyses.settings import ResultSettings
    from rigrunner_plugins.analyses.sources import Group

CURVATURE = "curvature of the model (second order)"
MOST_MISSED = 0.02
"""Greatest share of trials that may miss y ± U because of curvature; above it the check fails."""
MOST_ABOVE = 3.0
"""Greatest ratio of u to that of the trials; above it the check fails. Few degrees of freedom lower
it."""
DIGITS = 2


@dataclass(frozen=True)
class EquationAnalysis:
    """Implements `rigrunner.api.findings.Analysis`."""

    settings: EquationSettings

    def __call__(
        self,
        run: RunData,
        results: Sequence[MeasurementResult] = (),
        missing: Sequence[MissingResult] = (),
    ) -> Findings:
        """Return the results at each place; where the model has no value, which one and why."""
        settings = self.settings
        names = [each.of for each in settings.channels.values()]
        read = [name for name in names if is_read(run, name)]
        set_points = [name for name in names if name not in read]
        others = (*results, *missing)
        if lacking := missing_results(others, settings):
            return Findings(checks=(lacking,))
        found = (
            groups(
                run,
                read,
                set_points=set_points,
                per=settings.per,
                where=settings.where,
                table=settings.table,
            )
            if names
            else groups_of_results(others, settings)
        )
        definitions = settings.yields()
        evaluated = [self._at(run, others, group, definitions) for group in found]
        by_place = [[each for each in at if isinstance(each, Evaluated)] for at in evaluated]
        by_name = [each for at in zip(*evaluated, strict=True) for each in at]
        order = [each for each in by_name if isinstance(each, Evaluated)]
        of_results = {each.name: si_symbol(unit(each.of.unit).dimension) for each in others}
        return Findings(
            results=tuple(each.result for each in order),
            missing=tuple(each for each in by_name if isinstance(each, MissingResult)),
            checks=tuple(_checks(order)),
            notes=(
                *_notes(settings, order),
                *(
                    f"{name} counts as exact: the register has no entry for it."
                    for name in set_points
                    if name not in run.instruments
                ),
            ),
            formulas=tuple(formulas(settings)),
            tables=(
                *tables(settings, by_place, {**found[0].units, **of_results}),
                *(
                    table
                    for name in names_of(order)
                    for table in both_methods(
                        tried([each for each in order if each.result.name == name])
                    )
                ),
            ),
        )

    def _at(
        self,
        run: RunData,
        others: Sequence[ResultPlace],
        group: Group,
        definitions: Sequence[ResultDefinition],
    ) -> list[Evaluated | MissingResult]:
        results = results_at(others, self.settings, group.place)
        try:
            inputs = inputs_of(run, self.settings, group, results)
        except CorrelationError as error:
            return [
                MissingResult(of=each, coordinates=group.place, why=str(error))
                for each in definitions
            ]
        read = [len(group.times_s)] if self.settings.channels else []
        known = [each for each in results.values() if isinstance(each, MeasurementResult)]
        readings = min([*read, *(each.readings for each in known)], default=0)
        return [
            self._evaluated(inputs, told, definition, group, readings)
            for told, definition in zip(self.settings.all_results, definitions, strict=True)
        ]

    def _evaluated(
        self,
        inputs: Inputs,
        told: ResultSettings,
        definition: ResultDefinition,
        group: Group,
        readings: int,
    ) -> Evaluated | MissingResult:
        tree = inputs.tree(self.settings, told)
        model = inputs.model(tree)
        if not isfinite(model.value):
            part = tree.undefined({each.name: np.array(each.value) for each in model.inputs})
            source = self.settings.from_results.get(part)
            why = (
                f"'{part}' gives no finite number"
                if source is None
                else f"there is none of {source.of}"
            )
            return MissingResult(of=definition, coordinates=group.place, why=why)
        steep = [
            each.name
            for each, slope in zip(model.inputs, sensitivities(model), strict=True)
            if not isfinite(slope)
        ]
        if steep:
            why = (
                f"the model has no slope over {steep[0]}, and so no uncertainty: a root of 0,"
                " or another end of where a function is defined"
            )
            return MissingResult(of=definition, coordinates=group.place, why=why)
        try:
            found = propagate(model)
        except ValueError as error:
            raise DataError(f"{definition.name}: {error}") from error
        components = tuple(
            inputs.marked(_in_unit(model, each, definition.unit)) for each in found.components
        )
        estimate = replace(found.estimate, unit=definition.unit)
        added = 0.0
        if self.settings.second_order is not False and not isnan(estimate.u):
            added = self._added(added_variance(model, tree), estimate)
        if added > 0:
            estimate = _widened(estimate, added)
            u, symbol = sqrt(added), definition.unit
            components += (Component(CURVATURE, u, inf, "normal", common=False, unit=symbol,
                                     input_u=u, sensitivity=1.0),)  # fmt: skip
        result = MeasurementResult(
            of=definition,
            estimate=estimate,
            components=components,
            coordinates=group.place,
            readings=readings,
        )
        return Evaluated(result, model, found.estimate.u, added)

    def _added(self, added: float, estimate: Estimate) -> float:
        """Return how much second-order variance to include; 0 if it is negligible."""
        whole = sqrt(max(estimate.u**2 + added, 0.0))
        matters = abs(whole - estimate.u) > numerical_tolerance(estimate.u, DIGITS)
        return added if self.settings.second_order or matters else 0.0


def _in_unit(model: MeasurementModel, component: Component, symbol: str) -> Component:
    """Return a budget line of several inputs, converted to the unit of the result."""
    several = sum(each.budget_line == component.name for each in model.inputs) > 1
    return replace(component, unit=symbol) if several else component


def _widened(estimate: Estimate, added: float) -> Estimate:
    u = sqrt(estimate.u**2 + added)
    # Welch-Satterthwaite (GUM G.4.1): what is added has infinite degrees of freedom. The fourth
    # moment, and so the kurtosis, is shared out alike.
    share = (estimate.u / u) ** 4
    dof = estimate.dof / share if share > 0 else inf
    return replace(estimate, u=u, dof=dof, kurtosis=estimate.kurtosis * share)


def _checks(found: Sequence[Evaluated]) -> Iterator[Check]:
    """Yield a check for each result: whether y ± U covers the stated share of the trials."""
    for name in names_of(found):
        named = [one for one in found if one.result.name == name]
        trials = [(each, each.trial) for each in tried(named) if each.trial is not None]
        if not trials:
            continue
        worst, trial = max(trials, key=lambda pair: _missed(pair[1]))
        wide = [pair for pair in trials if pair[0].result.estimate.u > MOST_ABOVE * pair[1].u > 0]
        failed = [each for each, its in trials if _missed(its) > MOST_MISSED]
        failed += [each for each, _ in wide if each not in failed]
        about = failed if len(named) <= MOST_TRIED else named  # of others nobody knows
        of = tuple((name, each.result.coordinates) for each in about) if failed else ()
        if wide and _missed(trial) <= MOST_MISSED:
            yield replace(_too_wide(name, *wide[0], _elsewhere(failed, wide[0][0])), of=of)
            continue
        ok = _missed(trial) <= MOST_MISSED
        place = f" at {worst.result.place}" if worst.result.place else ""
        lost = f"; {trial.lost} of {TRIALS} trials have no value" if trial.lost else ""
        text = (
            f"y ± U holds {100 * trial.held:.0f} % of the trials{place}, and would hold"
            f" {100 * trial.held_if_straight:.0f} % if the model were straight{lost}"
            f"{_elsewhere(failed, worst)}"
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
            of=of,
        )


def _elsewhere(failed: Sequence[Evaluated], shown: Evaluated) -> str:
    """Return at which other places the check failed, as text; '' for none."""
    others = [each.result.place for each in failed if each is not shown]
    return f"; it fails too at {' and at '.join(others)}" if others else ""


def _too_wide(name: str, each: Evaluated, trial: Trial, elsewhere: str) -> Check:
    """Return a failed check: the second-order terms come from a kink or a pole."""
    u = each.result.estimate.u
    place = f" at {each.result.place}" if each.result.place else ""
    return Check(
        f"Monte Carlo of {name}",
        ok=False,
        text=f"u is {u:.2g}{place}, and {trial.u:.2g} of the trials{elsewhere}",
        advice="the model has a kink or a pole there: no terms of it describe the spread",
        value=u / trial.u,
        threshold=MOST_ABOVE,
        unit="1",
        decisive=True,
    )


def _missed(trial: Trial) -> float:
    """Return the share of trials that miss y ± U because of the model's curvature."""
    return max(trial.held_if_straight - trial.held, 0.0)


def _notes(settings: EquationSettings, found: Sequence[Evaluated]) -> Iterator[str]:
    bent = [each for each in found if each.added > 0]
    for name in names_of(bent):
        most = max((each for each in bent if each.result.name == name), key=lambda each: each.added)
        u = most.result.estimate.u
        yield (
            f"{name}: the curvature of the model counts: u is {u:.2g} {most.result.of.unit} with"
            f" the terms of second order (GUM 5.1.2, note), and {most.first_order_u:.2g} without."
        )
    for name in names_of(found):
        lines = (line.name for one in found if one.result.name == name
                 for line in one.result.components)  # fmt: skip
        for line in dict.fromkeys(each for each in lines if SEVERAL in each):
            yield (
                f"{name}: how much the inputs of '{line}' have in common is not known: the line is"
                " the greatest possible."
            )
    if not found:
        return
    first = found[0].result.name
    stated = [name for name, told in settings.channels.items() if not told.instrument]
    if stated:
        yield (
            f"{first}: of {', '.join(stated)} the errors that the register states are not used:"
            " they are among the constants, or left out."
        )
    single = any(each.result.readings == 1 for each in found)
    if single and any(told.instrument and not told.scatter for told in settings.channels.values()):
        yield (
            f"{first}: a value is a single reading, which shows no scatter: its uncertainty is the"
            " instrument's alone."
        )
