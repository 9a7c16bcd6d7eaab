"""The result over frequency, with its uncertainty and the limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.ticker import FuncFormatter

from rigrunner_reports.plots.canvas import GREY, INK, PRIMARY, VERMILION, Plot, draw

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.api.certificate import Certificate, Results
    from rigrunner_reports.certificate.wording import Wording

FEWEST_POINTS = 2
HEIGHT_IN = 2.6
LONGEST = 24
"""Letters of a text that somebody wrote: a longer one would leave no room for the plot."""


def over_frequency(certificate: Certificate, wording: Wording) -> Plot | None:
    """Return the figure; None where there are too few set-points for one."""
    results = certificate.results
    if results is None or len(results.points) < FEWEST_POINTS:
        return None

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        _points(axes, results, certificate.method.symbol)
        _mean(axes, results, wording)
        _limits(axes, certificate, wording)
        _axes(axes, results, certificate.method.symbol, wording)

    symbol = certificate.method.symbol
    caption = wording.texts("figure", symbol=symbol)
    return Plot(
        caption=caption, alt=_alt(certificate, results, wording), svg=draw(paint, HEIGHT_IN)
    )


def _points(axes: Axes, results: Results, symbol: str) -> None:
    points = results.points
    axes.errorbar(
        [each.frequency_hz for each in points],
        [each.torque.value for each in points],
        yerr=[each.torque.expanded_uncertainty for each in points],
        color=PRIMARY.color,
        marker=PRIMARY.marker,
        linestyle="none",
        label=f"{symbol[:LONGEST]} ± U",
    )


def _mean(axes: Axes, results: Results, wording: Wording) -> None:
    mean = results.headline
    low, high = (mean.value + sign * mean.expanded_uncertainty for sign in (-1, 1))
    axes.axhspan(low, high, color=GREY, alpha=0.25, linewidth=0)
    label = f"{wording.texts('figure.mean')} {wording.interval(mean)}"
    axes.axhline(mean.value, color=GREY, linestyle="-", linewidth=1, label=label)


def _limits(axes: Axes, certificate: Certificate, wording: Wording) -> None:
    stated = certificate.conformity.statements if certificate.conformity else ()
    first = next((each for each in stated if each.measurand), None)
    if first is None:
        return
    label = f"{wording.texts('figure.limit')} {wording.number(first.limit[:LONGEST])}"
    for limit in (first.lower, first.upper):
        if limit is not None:
            axes.axhline(limit, color=VERMILION, linestyle="--", linewidth=1.4, label=label)
            label = "_nolegend_"


def _axes(axes: Axes, results: Results, symbol: str, wording: Wording) -> None:
    speed = results.motion == "start"
    axes.set_xlabel(wording.texts("points.speed" if speed else "points.frequency"))
    axes.set_ylabel(wording.texts("points.torque", symbol=symbol[:LONGEST]))
    shown = FuncFormatter(lambda value, _: wording.number(f"{value:.6g}"))
    axes.xaxis.set_major_formatter(shown)
    axes.yaxis.set_major_formatter(shown)
    axes.margins(y=0.12)
    axes.tick_params(labelcolor=INK)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)


def _alt(certificate: Certificate, results: Results, wording: Wording) -> str:
    points = "; ".join(
        wording.texts(
            "figure.alt.point",
            frequency=wording.plain(each.set_frequency_hz),
            value=wording.number(each.torque.printed),
            u=wording.number(each.torque.printed_uncertainty),
        )
        for each in results.points
    )
    found = wording.texts("figure.alt", symbol=certificate.method.symbol, points=points)
    if certificate.conformity is None:
        return found
    limit = wording.number(certificate.conformity.statements[0].limit)
    return f"{found} {wording.texts('figure.alt.limit', limit=limit)}."
