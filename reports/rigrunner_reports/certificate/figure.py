"""The figures of a certificate: results with their uncertainty and limits, in its language."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.figures import Axis, Figure, Mark, Picture, Point, Series

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.certificate import Certificate, LimitStatement, NamedResult, Results
    from rigrunner_reports.certificate.wording import Wording

FEWEST_POINTS = 2
LONGEST = 24
"""Longest text of a person, in letters: a longer one would leave no room for the plot."""


def over_frequency(certificate: Certificate, wording: Wording) -> Picture | None:
    """Return the figure of the points; None if there are too few."""
    results = certificate.results
    if results is None or len(results.points) < FEWEST_POINTS:
        return None
    symbol = certificate.method.symbol[:LONGEST]
    speed = results.motion == "start"
    mean = results.headline
    ends = {point.frequency_hz for point in results.points}
    series = (
        Series.over(
            (point.frequency_hz for point in results.points),
            (point.torque.value for point in results.points),
            f"{symbol} ± U",
            U=(point.torque.expanded_uncertainty for point in results.points),
        ),
        Series.over(
            (min(ends), max(ends)),
            (mean.value, mean.value),
            f"{wording.texts('figure.mean')} {wording.interval(mean)}",
            "line",
            U=(mean.expanded_uncertainty, mean.expanded_uncertainty),
        ),
    )
    figure = Figure(
        "",
        Axis(wording.texts("points.speed" if speed else "points.frequency")),
        Axis(wording.texts("points.torque", symbol=symbol)),
        series,
        tuple(_limits(certificate, wording)),
    )
    caption = wording.texts("figure", symbol=certificate.method.symbol)
    alt = _alt(certificate, results, wording)
    return Picture(caption, alt, (figure,), decimal=wording.texts("decimal"))


def named_figures(certificate: Certificate, wording: Wording) -> dict[str, Picture]:
    """Return the figure of each result with several values over one number, by its name."""
    return {
        name: _figure(certificate, results, wording)
        for name, results in wording.by_name(certificate)
        if len(results[0].coordinates) == 1
        and len(results) >= FEWEST_POINTS
        and not any(isinstance(x.value, str) for at in results for x in at.coordinates.values())
    }


def _figure(certificate: Certificate, results: Sequence[NamedResult], wording: Wording) -> Picture:
    first = results[0]
    ((axis, at),) = first.coordinates.items()
    symbol, unit = first.symbol or first.name, first.found.unit
    stated = certificate.conformity.statements if certificate.conformity else ()
    limits = [statement for statement in stated if statement.named == first.name]
    points = tuple(_point(result, axis, at.unit, limits) for result in results)
    series = Series(f"{symbol} ± U", points)
    label = wording.texts("figure.limit")
    marks = tuple(
        Mark("y", end, name=label, is_limit=True)
        for statement in limits
        if not statement.coordinates
        for end in (statement.lower, statement.upper)
        if end is not None
    )
    figure = Figure("", Axis(axis, at.unit), Axis(symbol, unit), (series,), marks)
    values = "; ".join(
        f"{value.printed}: {result.found.printed} ± {result.found.printed_uncertainty}"
        for result in results
        for value in result.coordinates.values()
    )
    caption = wording.texts("named.figure", symbol=symbol, axis=axis)
    alt = wording.number(f"{symbol}, {unit}. {values}.")
    return Picture(caption, alt, (figure,), limit=label, decimal=wording.texts("decimal"))


def _point(result: NamedResult, axis: str, symbol: str, stated: Sequence[LimitStatement]) -> Point:
    here = (statement for statement in stated if statement.coordinates == result.coordinates)
    limit = next(here, None)
    at = result.coordinates[axis]
    return Point(
        float(CoordinateValue(at.value, at.unit).in_unit(symbol).value),
        result.found.value,
        result.found.expanded_uncertainty,
        None if limit is None else limit.lower,
        None if limit is None else limit.upper,
    )


def _limits(certificate: Certificate, wording: Wording) -> Iterator[Mark]:
    stated = certificate.conformity.statements if certificate.conformity else ()
    first = next((statement for statement in stated if statement.measurand), None)
    if first is not None:
        label = f"{wording.texts('figure.limit')} {wording.number(first.limit[:LONGEST])}"
        for limit in (first.lower, first.upper):
            if limit is not None:
                yield Mark("y", limit, name=label, is_limit=True)


def _alt(certificate: Certificate, results: Results, wording: Wording) -> str:
    points = "; ".join(
        wording.texts(
            "figure.alt.point",
            frequency=wording.plain(point.set_frequency_hz),
            value=wording.number(point.torque.printed),
            u=wording.number(point.torque.printed_uncertainty),
        )
        for point in results.points
    )
    text = wording.texts("figure.alt", symbol=certificate.method.symbol, points=points)
    if certificate.conformity is None:
        return text
    limit = wording.number(certificate.conformity.statements[0].limit)
    return f"{text} {wording.texts('figure.alt.limit', limit=limit)}."
