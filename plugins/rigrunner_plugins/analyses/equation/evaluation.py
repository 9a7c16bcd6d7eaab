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
    to_try,
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
        names = [channel.of for channel in settings.channels.values()]
        channels = [name for name in names if is_read(run, name)]
        set_points = [name for name in names if name not in channels]
        others = (*results, *missing)
        if missing_check := missing_results(others, settings):
            return Findings(checks=(missing_check,))
        place_groups = (
            groups(
                run,
                channels,
                set_points=set_points,
                per=settings.per,
                where=settings.where,
                table=settings.table,
            )
            if names
            else groups_of_results(others, settings)
        )
        definitions = settings.yields()
        rows = [self._evaluate_place(run, others, group, definitions) for group in place_groups]
        by_place = [[result for result in row if isinstance(result, Evaluated)] for row in rows]
        by_name = [result for row in zip(*rows, strict=True) for result in row]
        ordered = [result for result in by_name if isinstance(result, Evaluated)]
        result_units = {result.name: si_symbol(unit(result.of.unit).dimension) for result in others}
        return Findings(
            results=tuple(evaluated.result for evaluated in ordered),
            missing=tuple(result for result in by_name if isinstance(result, MissingResult)),
            checks=tuple(_checks(ordered)),
            notes=(
                *_notes(settings, ordered),
                *(
                    f"{name} counts as exact: the register has no entry for it."
                    for name in set_points
                    if name not in run.instruments
                ),
            ),
            formulas=tuple(formulas(settings)),
            tables=(
                *tables(settings, by_place, {**place_groups[0].units, **result_units}),
                *(
                    table
                    for name in names_of(ordered)
                    for table in both_methods(
                        to_try([result for result in ordered if result.result.name == name])
                    )
                ),
            ),
        )

    def _evaluate_place(
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
                MissingResult(of=definition, coordinates=group.place, why=str(error))
                for definition in definitions
            ]
        counts = [len(group.times_s)] if self.settings.channels else []
        valued = [result for result in results.values() if isinstance(result, MeasurementResult)]
        readings = min([*counts, *(result.readings for result in valued)], default=0)
        return [
            self._evaluate(inputs, result, definition, group, readings)
            for result, definition in zip(self.settings.all_results, definitions, strict=True)
        ]

    def _evaluate(
        self,
        inputs: Inputs,
        result_settings: ResultSettings,
        definition: ResultDefinition,
        group: Group,
        readings: int,
    ) -> Evaluated | MissingResult:
        tree = inputs.tree(self.settings, result_settings)
        model = inputs.model(tree)
        if not isfinite(model.value):
            part = tree.undefined({input_.name: np.array(input_.value) for input_ in model.inputs})
            source = self.settings.from_results.get(part)
            why = (
                f"'{part}' gives no finite number"
                if source is None
                else f"there is none of {source.of}"
            )
            return MissingResult(of=definition, coordinates=group.place, why=why)
        steep = [
            input_.name
            for input_, slope in zip(model.inputs, sensitivities(model), strict=True)
            if not isfinite(slope)
        ]
        if steep:
            why = (
                f"the model has no slope over {steep[0]}, and so no uncertainty: a root of 0,"
                " or another end of where a function is defined"
            )
            return MissingResult(of=definition, coordinates=group.place, why=why)
        try:
            propagated = propagate(model)
        except ValueError as error:
            raise DataError(f"{definition.name}: {error}") from error
        components = tuple(
            inputs.with_sharing(_in_unit(model, component, definition.unit))
            for component in propagated.components
        )
        estimate = replace(propagated.estimate, unit=definition.unit)
        added = 0.0
        if self.settings.second_order is not False and not isnan(estimate.u):
            added = self._second_order_variance(added_variance(model, tree), estimate)
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
        return Evaluated(result, model, propagated.estimate.u, added)

    def _second_order_variance(self, added: float, estimate: Estimate) -> float:
        """Return how much second-order variance to include; 0 if it is negligible."""
        combined_u = sqrt(max(estimate.u**2 + added, 0.0))
        matters = abs(combined_u - estimate.u) > numerical_tolerance(estimate.u, DIGITS)
        return added if self.settings.second_order or matters else 0.0


def _in_unit(model: MeasurementModel, component: Component, symbol: str) -> Component:
    """Return a budget line of several inputs, converted to the unit of the result."""
    is_of_several = sum(input_.budget_line == component.name for input_ in model.inputs) > 1
    return replace(component, unit=symbol) if is_of_several else component


def _widened(estimate: Estimate, added: float) -> Estimate:
    u = sqrt(estimate.u**2 + added)
    # Welch-Satterthwaite (GUM G.4.1): what is added has infinite degrees of freedom. The fourth
    # moment, and so the kurtosis, is shared out alike.
    share = (estimate.u / u) ** 4
    dof = estimate.dof / share if share > 0 else inf
    return replace(estimate, u=u, dof=dof, kurtosis=estimate.kurtosis * share)


def _checks(results: Sequence[Evaluated]) -> Iterator[Check]:
    """Yield a check for each result: whether y ± U covers the stated share of the trials."""
    for name in names_of(results):
        named = [evaluated for evaluated in results if evaluated.result.name == name]
        trials = [(each, each.trial) for each in to_try(named) if each.trial is not None]
        if not trials:
            continue
        worst, trial = max(trials, key=lambda pair: _missed_share(pair[1]))
        wide = [pair for pair in trials if pair[0].result.estimate.u > MOST_ABOVE * pair[1].u > 0]
        failed = [evaluated for evaluated, trial in trials if _missed_share(trial) > MOST_MISSED]
        failed += [evaluated for evaluated, _ in wide if evaluated not in failed]
        affected = failed if len(named) <= MOST_TRIED else named  # the others were not tried
        places = tuple((name, each.result.coordinates) for each in affected) if failed else ()
        if wide and _missed_share(trial) <= MOST_MISSED:
            yield replace(_too_wide(name, *wide[0], _elsewhere(failed, wide[0][0])), of=places)
            continue
        ok = _missed_share(trial) <= MOST_MISSED
        place = f" at {worst.result.place}" if worst.result.place else ""
        lost = f"; {trial.lost} of {TRIALS} trials have no value" if trial.lost else ""
        text = (
            f"y ± U holds {100 * trial.coverage:.0f} % of the trials{place}, and would hold"
            f" {100 * trial.coverage_if_linear:.0f} % if the model were straight{lost}"
            f"{_elsewhere(failed, worst)}"
        )
        advice = "the model is too curved for these inputs: measure them better"
        yield Check(
            f"Monte Carlo of {name}",
            ok=ok,
            text=text,
            advice="" if ok else advice,
            value=_missed_share(trial),
            threshold=MOST_MISSED,
            unit="1",
            decisive=True,
            of=places,
        )


def _elsewhere(failed: Sequence[Evaluated], shown: Evaluated) -> str:
    """Return at which other places the check failed, as text; '' for none."""
    others = [evaluated.result.place for evaluated in failed if evaluated is not shown]
    return f"; it fails too at {' and at '.join(others)}" if others else ""


def _too_wide(name: str, evaluated: Evaluated, trial: Trial, elsewhere: str) -> Check:
    """Return a failed check: the second-order terms come from a kink or a pole."""
    u = evaluated.result.estimate.u
    place = f" at {evaluated.result.place}" if evaluated.result.place else ""
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


def _missed_share(trial: Trial) -> float:
    """Return the share of trials that miss y ± U because of the model's curvature."""
    return max(trial.coverage_if_linear - trial.coverage, 0.0)


def _notes(settings: EquationSettings, results: Sequence[Evaluated]) -> Iterator[str]:
    bent = [evaluated for evaluated in results if evaluated.added > 0]
    for name in names_of(bent):
        most = max((each for each in bent if each.result.name == name), key=lambda each: each.added)
        u = most.result.estimate.u
        yield (
            f"{name}: the curvature of the model counts: u is {u:.2g} {most.result.of.unit} with"
            f" the terms of second order (GUM 5.1.2, note), and {most.first_order_u:.2g} without."
        )
    for name in names_of(results):
        lines = (line.name for evaluated in results if evaluated.result.name == name
                 for line in evaluated.result.components)  # fmt: skip
        for line in dict.fromkeys(line for line in lines if SEVERAL in line):
            yield (
                f"{name}: how much the inputs of '{line}' have in common is not known: the line is"
                " the greatest possible."
            )
    if not results:
        return
    first = results[0].result.name
    stated = [name for name, channel in settings.channels.items() if not channel.instrument]
    if stated:
        yield (
            f"{first}: of {', '.join(stated)} the errors that the register states are not used:"
            " they are among the constants, or left out."
        )
    single = any(evaluated.result.readings == 1 for evaluated in results)
    channels = settings.channels.values()
    if single and any(channel.instrument and not channel.scatter for channel in channels):
        yield (
            f"{first}: a value is a single reading, which shows no scatter: its uncertainty is the"
            " instrument's alone."
        )
