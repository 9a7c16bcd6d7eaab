"""Results with their uncertainty, and the decisions on them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.certificate import (
    BudgetLine,
    CertifiedDetails,
    Conformity,
    CoordinatePart,
    Equation,
    LimitStatement,
    MeasuredLimits,
    MeasuredValue,
    MeasurementModel,
    NamedResult,
    Results,
)
from rigrunner.api.coordinates import written_text
from rigrunner.api.errors import DataError
from rigrunner.api.units import with_symbol
from rigrunner.signal.numerals import finite, percent, stated
from rigrunner.signal.rounding import printed

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.analysis import Component
    from rigrunner.api.certificate import DecisionRecord
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.results import JudgedValue, Result
    from rigrunner.api.verdict import Decision, LimitDecision


MOST_VALUES = 500
"""Number of measured values that are listed; the run has all."""


def measured_of(result: Result) -> MeasuredLimits | None:
    """Return the measured values with limits and their decisions; None for none.

    Readings that are not numbers count for the verdict, and are not listed.
    """
    limits = result.limits
    if limits.verdict is None:
        return None
    values = tuple(value for value in limits.values if value.decision.of in value.row.values)
    if len(values) > MOST_VALUES:
        values = tuple(sorted(values, key=lambda value: value.decision.passes))[:MOST_VALUES]
    return MeasuredLimits(
        verdict="fail" if limits.missed else "pass",
        reason=limits.reason,
        judged=len(limits.values),
        missed=len(limits.missed),
        values=tuple(map(_measured_value, values)),
    )


def _measured_value(value: JudgedValue) -> MeasuredValue:
    row, decision = value.row, value.decision
    return MeasuredValue(
        table=row.name,
        row=value.number,
        utc=row.utc,
        setpoints={
            name: written_text(setpoint, "", row.written_in[name])
            if name in row.written_in
            else f"{setpoint:.6g} {row.units.get(name, '')}".rstrip()
            for name, setpoint in row.setpoints.items()
        },
        of=decision.of,
        value=value.value,
        lower=finite(decision.limits.lower),
        upper=finite(decision.limits.upper),
        unit=row.units.get(decision.of, ""),
        printed=value.shown,
        printed_limit=decision.limits.in_signs,
        verdict="pass" if decision.passes else "fail",
    )


def certified_of(result: Result) -> tuple[CertifiedDetails, ...]:
    """Return the parts that analyses add; raise DataError if there is nothing to certify."""
    parts = (details.certified(result.run) for details in result.details)
    certified = tuple(part for part in parts if part is not None)
    has_results = any(part.results for part in certified)
    if not (has_results or result.other_results or result.limits.values):
        reason = result.notes[0] if result.notes else "its procedure names no primary method"
        raise DataError(f"{result.run.run_id} has no result to certify: {reason}")
    return certified


def results_of(result: Result) -> Results | None:
    """Return the results that an analysis states with their set-points; None for none.

    Otherwise the certificate states named results, or measured values with limits. Raises
    DataError.
    """
    return next((part.results for part in certified_of(result) if part.results), None)


def named_of(result: Result) -> tuple[NamedResult, ...]:
    """Return the named results; raise DataError for one with unknown uncertainty."""
    return tuple(
        NamedResult(
            name=named.name,
            symbol=named.of.symbol,
            text=named.of.words,
            coordinates=_coordinates(named.coordinates),
            found=stated(
                named.estimate, f"{named.name} at {named.place}" if named.place else named.name
            ),
            readings=named.readings,
        )
        for named in result.other_results
    )


def models_of(result: Result) -> Iterator[MeasurementModel]:
    """Yield the measurement models of the named results calculated by equations."""
    estimate = None if result.decision is None else result.decision.deciding.result
    for name in dict.fromkeys(named.name for named in result.other_results):
        equations = tuple(
            Equation(symbol=formula.symbol, text=formula.text, quantities=dict(formula.quantities))
            for formula in result.formulas
            if formula.of == name and not formula.is_curve
        )
        if equations:
            results = [named for named in result.other_results if named.name == name]
            example = next((named for named in results if named.estimate is estimate), results[0])
            yield MeasurementModel(
                name=name,
                equations=equations,
                coordinates=_coordinates(example.coordinates),
                budget=tuple(map(_line, example.components)),
            )


def _line(component: Component) -> BudgetLine:
    return BudgetLine(
        name=component.name,
        distribution=component.distribution,
        degrees_of_freedom=finite(component.dof),
        standard_uncertainty=finite(component.input_u),
        unit=component.unit,
        sensitivity=finite(component.sensitivity),
        contribution=float(component.u),
    )


def _coordinates(coordinates: Mapping[str, CoordinateValue]) -> dict[str, CoordinatePart]:
    return {
        name: CoordinatePart(value=coordinate.value, unit=coordinate.unit, printed=str(coordinate))
        for name, coordinate in coordinates.items()
    }


def conformity_of(
    decision: Decision | None, decided_again: tuple[DecisionRecord, ...]
) -> Conformity | None:
    """Return the statement of conformity; None without limits."""
    if decision is None:
        return None
    name, _, words = decision.rule.partition(": ")
    # A copy of one of the parts, with another reason: its limit identifies it.
    first = decision.deciding
    others = (
        part
        for part in decision.parts
        if (part.of, part.limits, part.source) != (first.of, first.limits, first.source)
    )
    return Conformity(
        verdict=str(decision.verdict),
        rule=name,
        rule_words=words,
        rule_words_in=dict(decision.rule_in),
        statements=tuple(_statement(part) for part in (first, *others)),
        decided_again=decided_again,
    )


def _statement(decision: LimitDecision) -> LimitStatement:
    probability, band = finite(decision.probability), finite(decision.guard_band)
    result = None if decision.result is None else stated(decision.result, decision.of)
    decimals = 0 if result is None else result.decimals
    measurand = {} if decision.measurand is None else decision.measurand.document()
    load = measurand.get("load")  # has a field of its own in certificates of 0.1.0
    load = load.get("value") if isinstance(load, dict) else None
    return LimitStatement(
        of=decision.of,
        named=decision.named,
        coordinates=_coordinates(decision.coordinates),
        printed_result=""
        if result is None
        else with_symbol(f"{result.printed} ± {result.printed_uncertainty}", result.unit),
        unit=decision.limits.unit,
        verdict=str(decision.verdict),
        reason=decision.reason,
        limit=str(decision.limits),
        lower=finite(decision.limits.lower),
        upper=finite(decision.limits.upper),
        source=decision.source,
        measurand=str(measurand.get("text", "")),
        load_n=load if isinstance(load, float) else None,
        guard_band=band,
        printed_guard_band=""
        if band is None
        else with_symbol(printed(band, decimals), decision.limits.unit),
        stated_risk=finite(decision.false_accept_risk),
        probability_of_conformity=probability,
        printed_probability="" if probability is None else percent(probability),
        uncompensated="" if decision.uncompensated is None else str(decision.uncompensated),
        marginal=decision.marginal,
    )
