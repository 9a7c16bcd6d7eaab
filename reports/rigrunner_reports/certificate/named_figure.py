"""Named results over a coordinate, with their uncertainty and limits, on a certificate."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from matplotlib.ticker import FuncFormatter

from rigrunner.api.coordinates import CoordinateValue
from rigrunner.plots.results import limit_lines
from rigrunner_reports.plots.canvas import INK, PRIMARY, VERMILION, Plot, draw

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from rigrunner.api.certificate import Certificate, CoordinatePart, LimitStatement, NamedResult
    from rigrunner_reports.certificate.wording import Wording

FEWEST_POINTS = 2
HEIGHT_IN = 2.6


def named_figures(certificate: Certificate, wording: Wording) -> dict[str, Plot]:
    """Return the figure of each result that has several values over one number, by its name."""
    return {
        name: _figure(certificate, results, wording)
        for name, results in wording.by_name(certificate)
        if len(results[0].coordinates) == 1
        and len(results) >= FEWEST_POINTS
        and not any(isinstance(x.value, str) for each in results for x in each.coordinates.values())
    }


def _figure(certificate: Certificate, results: Sequence[NamedResult], wording: Wording) -> Plot:
    first = results[0]
    ((axis, at),) = first.coordinates.items()
    symbol = first.symbol or first.name
    x = [_number(each.coordinates[axis], at.unit) for each in results]
    limits = _limits(certificate, first.name, axis, at.unit)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.errorbar(
            x,
            [each.found.value for each in results],
            yerr=[each.found.expanded_uncertainty for each in results],
            color=PRIMARY.color,
            marker=PRIMARY.marker,
            linestyle="none",
            label=f"{symbol} ± U",
        )
        label = wording.texts("figure.limit")
        for where, limit in limits:
            if where:
                axes.plot(where, limit, color=VERMILION, linestyle="--", linewidth=1.4, label=label)
            else:
                axes.axhline(limit[0], color=VERMILION, linestyle="--", linewidth=1.4, label=label)
            label = "_nolegend_"
        shown = FuncFormatter(lambda value, _: wording.number(f"{value:.6g}"))
        axes.xaxis.set_major_formatter(shown)
        axes.yaxis.set_major_formatter(shown)
        axes.set_xlabel(f"{axis}, {at.unit}" if at.unit else axis)
        axes.set_ylabel(f"{symbol}, {first.found.unit}")
        axes.margins(y=0.12)
        axes.tick_params(labelcolor=INK)
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)

    told = "; ".join(
        f"{value.printed}: {each.found.printed} ± {each.found.printed_uncertainty}"
        for each in results
        for value in each.coordinates.values()
    )
    caption = wording.texts("named.figure", symbol=symbol, axis=axis)
    alt = wording.number(f"{symbol}, {first.found.unit}. {told}.")
    return Plot(caption=caption, alt=alt, svg=draw(paint, HEIGHT_IN))


def _limits(
    certificate: Certificate, name: str, axis: str, symbol: str
) -> list[tuple[list[float], list[float]]]:
    stated = certificate.conformity.statements if certificate.conformity else ()
    return list(limit_lines(_held(each, axis, symbol) for each in stated if each.named == name))


def _held(stated: LimitStatement, axis: str, symbol: str) -> tuple[float | None, float, float]:
    place = stated.coordinates.get(axis)
    x = None if place is None or isinstance(place.value, str) else _number(place, symbol)
    lower, upper = stated.lower, stated.upper
    return x, -inf if lower is None else lower, inf if upper is None else upper


def _number(place: CoordinatePart, symbol: str) -> float:
    return float(CoordinateValue(place.value, place.unit).in_unit(symbol).value)
