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
    found = result.limits
    if found.verdict is None:
        return None
    values = tuple(each for each in found.values if each.decision.of in each.row.values)
    if len(values) > MOST_VALUES:
        values = tuple(sorted(values, key=lambda each: each.decision.passes))[:MOST_VALUES]
    return MeasuredLimits(
        verdict="fail" if found.missed else "pass",
        reason=found.reason,
        judged=len(found.values),
        missed=len(found.missed),
        values=tuple(map(_measured_value, values)),
    )


def _measured_value(found: JudgedValue) -> MeasuredValue:
    row, decided = found.row, found.decision
    return MeasuredValue(
        table=row.name,
        row=found.number,
        utc=row.utc,
        setpoints={
            name: written_text(value, "", row.written_in[name])
            if name in row.written_in
            else f"{value:.6g} {row.units.get(name, '')}".rstrip()
            for name, value in row.setpoints.items()
        },
        of=decided.of,
        value=found.value,
        lower=finite(decided.limits.lower),
        upper=finite(decided.limits.upper),
        unit=row.units.get(decided.of, ""),
        printed=found.shown,
        printed_limit=decided.limits.in_signs,
        verdict="pass" if decided.passes else "fail",
    )


def certified_of(result: Result) -> tuple[CertifiedDetails, ...]:
    """Return the parts that analyses add; raise DataError if there is nothing to certify."""
    brought = (each.certified(result.run) for each in result.details)
    found = tuple(each for each in brought if each is not None)
    has_results = any(each.results for each in found)
    if not (has_results or result.other_results or result.limits.values):
        reason = result.notes[0] if result.notes else "its procedure names no primary method"
        raise DataError(f"{result.run.run_id} has no result to certify: {reason}")
    return found


def results_of(result: Result) -> Results | None:
    """Return the results that an analysis states with their set-points; None for none.

    Otherwise the certificate states named results, or measured values with limits. Raises
    DataError.
    """
    return next((each.results for each in certified_of(result) if each.results), None)


def named_of(result: Result) -> tuple[NamedResult, ...]:
    """Return the named results; raise DataError for one with unknown uncertainty."""
    return tuple(
        NamedResult(
            name=each.name,
            symbol=each.of.symbol,
            text=each.of.words,
            coordinates=_coordinates(each.coordinates),
            found=stated(
                each.estimate, f"{each.name} at {each.place}" if each.place else each.name
            ),
            readings=each.readings,
        )
        for each in result.other_results
    )


def models_of(result: Result) -> Iterator[MeasurementModel]:
    """Yield the measurement models of the named results calculated by equations."""
    deciding = None if result.decision is None else result.decision.deciding.result
    for name in dict.fromkeys(each.name for each in result.other_results):
        equations = tuple(
            Equation(symbol=each.symbol, text=each.text, quantities=dict(each.quantities))
            for each in result.formulas
            if each.of == name and not each.is_curve
        )
        if equations:
            own = [each for each in result.other_results if each.name == name]
            shown = next((each for each in own if each.estimate is deciding), own[0])
            yield MeasurementModel(
                name=name,
                equations=equations,
                coordinates=_coordinates(shown.coordinates),
                budget=tuple(map(_line, shown.components)),
            )


def _line(found: Component) -> BudgetLine:
    return BudgetLine(
        name=found.name,
        distribution=found.distribution,
        degrees_of_freedom=finite(found.dof),
        standard_uncertainty=finite(found.input_u),
        unit=found.unit,
        sensitivity=finite(found.sensitivity),
        contribution=float(found.u),
    )


def _coordinates(found: Mapping[str, CoordinateValue]) -> dict[str, CoordinatePart]:
    return {
        name: CoordinatePart(value=each.value, unit=each.unit, printed=str(each))
        for name, each in found.items()
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
        each
        for each in decision.parts
        if (each.of, each.limits, each.source) != (first.of, first.limits, first.source)
    )
    return Conformity(
        verdict=str(decision.verdict),
        rule=name,
        rule_words=words,
        rule_words_in=dict(decision.rule_in),
        statements=tuple(_statement(each) for each in (first, *others)),
        decided_again=decided_again,
    )


def _statement(found: LimitDecision) -> LimitStatement:
    probability, band = finite(found.probability), finite(found.guard_band)
    result = None if found.result is None else stated(found.result, found.of)
    decimals = 0 if result is None else result.decimals
    measurand = {} if found.measurand is None else found.measurand.document()
    load = measurand.get("load")  # has a field of its own in certificates of 0.1.0
    load = load.get("value") if isinstance(load, dict) else None
    return LimitStatement(
        of=found.of,
        named=found.named,
        coordinates=_coordinates(found.coordinates),
        printed_result=""
        if result is None
        else with_symbol(f"{result.printed} ± {result.printed_uncertainty}", result.unit),
        unit=found.limits.unit,
        verdict=str(found.verdict),
        reason=found.reason,
        limit=str(found.limits),
        lower=finite(found.limits.lower),
        upper=finite(found.limits.upper),
        source=found.source,
        measurand=str(measurand.get("text", "")),
        load_n=load if isinstance(load, float) else None,
        guard_band=band,
        printed_guard_band=""
        if band is None
        else with_symbol(printed(band, decimals), found.limits.unit),
        stated_risk=finite(found.false_accept_risk),
        probability_of_conformity=probability,
        printed_probability="" if probability is None else percent(probability),
        uncompensated="" if found.uncompensated is None else str(found.uncompensated),
        marginal=found.marginal,
    )
