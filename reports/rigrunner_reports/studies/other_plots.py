"""The figures of a capability and of a gauge study.

Names that people gave stand in the page, not in figures, whose font lacks most of the world's
letters: parts have numbers here and operators letters.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner_reports.numbers import fixed
from rigrunner_reports.plots.canvas import BLUE, GREEN, GREY, INK, OCHRE, PURPLE, VERMILION, Plot
from rigrunner_reports.plots.canvas import draw as drawn
from rigrunner_reports.studies.numbers import as_scattered

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.api.studies import CapabilitySeries, CapabilityStudy, GaugeStudy

_DASHED = (0, (6, 3))
_LOOKS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"), (PURPLE, "D"), (OCHRE, "v"), (GREY, "P"))
MOST_NAMED = 30
"""Parts whose numbers stand under the figure."""


def distribution(study: CapabilityStudy, series: CapabilitySeries) -> Plot:
    """Return the figure of the values of one group, with the limits and the normal curve."""
    values = np.array([each.value for each in series.observed])
    mean, deviation = series.capability.mean, series.capability.standard_deviation
    limits = [each for each in (study.lower, study.upper) if each is not None]
    low, high = min(values.min(), *limits), max(values.max(), *limits)
    x = np.linspace(min(low, mean - 4 * deviation), max(high, mean + 4 * deviation), 300)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.hist(values, bins="auto", density=True, color="#B9D3E6", label="values")
        curve = np.exp(-0.5 * ((x - mean) / deviation) ** 2) / (deviation * np.sqrt(2 * np.pi))
        axes.plot(x, curve, color=BLUE, label="normal, of their mean and deviation")
        for value in limits:
            is_lower = value == study.lower  # named inwards: outside is no room
            axes.axvline(value, color=VERMILION, linestyle=_DASHED)
            axes.annotate(
                f"limit {value:g} {study.unit}",
                (value, 0.97),
                xycoords=("data", "axes fraction"),
                xytext=(4 if is_lower else -4, 0),
                textcoords="offset points",
                ha="left" if is_lower else "right",
                fontsize=7.5,
            )
        axes.set(xlabel=f"value / {study.unit}", ylabel="density")
        axes.set_yticks([])
        figure.legend(loc="outside upper center", ncols=2)

    return Plot(
        caption=f"{series.name}. The values, and the normal curve that the indices rest on.",
        alt=f"{len(values)} values from {as_scattered(values.min(), deviation)} to "
        f"{as_scattered(values.max(), deviation)}, mean {as_scattered(mean, deviation)}.",
        svg=drawn(paint, 2.7),
    )


def readings(study: GaugeStudy) -> Plot:
    """Return the figure of all readings, by part and operator."""

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for place in range(len(study.operators)):
            _operator(axes, study, place)
        axes.set(ylabel=f"value / {study.unit}", xlabel="part")
        step = -(-len(study.parts) // MOST_NAMED)
        named = range(0, len(study.parts), step)
        axes.set_xticks(named, [str(each + 1) for each in named])
        axes.grid(visible=False, axis="x")
        figure.legend(loc="outside upper center", ncols=min(6, len(study.operators)))

    found = study.analysis.components
    return Plot(
        caption="All readings. Operators stand side by side within a part; the line joins the mean "
        "of each operator's readings. Lines that run apart or cross show operators that measure "
        "parts differently; points far apart show a gauge that does not repeat.",
        alt=f"Readings of {len(study.parts)} parts by {len(study.operators)} operators. Standard "
        f"deviation of the gauge {fixed(found.gauge, 5)}, of the parts {fixed(found.part, 5)} "
        f"{study.unit}.",
        svg=drawn(paint, 3.4),
    )


def components(study: GaugeStudy) -> Plot:
    """Return the figure of what the total variation consists of."""
    found = study.analysis.components
    named = {
        "gauge R&R": found.gauge,
        "repeatability": found.repeatability,
        "reproducibility": found.reproducibility,
        "part": found.part,
    }

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        place = np.arange(len(named))
        deviations = np.array(list(named.values())) / found.total
        axes.barh(place - 0.19, 100 * deviations**2, 0.36, color=BLUE, label="% of variance")
        axes.barh(place + 0.19, 100 * deviations, 0.36, color="#B9D3E6", label="% of deviation")
        axes.set_yticks(place, list(named))
        axes.invert_yaxis()
        axes.set(xlabel="%", xlim=(0, 100))
        axes.axvline(100, color=INK, linewidth=0.6)
        figure.legend(loc="outside upper center", ncols=2)

    told = ", ".join(f"{name} {fixed(100 * s / found.total, 1)} %" for name, s in named.items())
    return Plot(
        caption="What the total variation consists of. Variances add up; deviations do not.",
        alt=f"Share of the total standard deviation: {told}.",
        svg=drawn(paint, 2.4),
    )


def _operator(axes: Axes, study: GaugeStudy, place: int) -> None:
    color, marker = _LOOKS[place % len(_LOOKS)]
    room = 0.6 / len(study.operators)
    offset = (place - (len(study.operators) - 1) / 2) * room
    cells = np.array([part[place] for part in study.readings])
    x = np.arange(len(study.parts)) + offset
    axes.plot(x, cells.mean(axis=1), color=color, linewidth=0.9, label=letter(place))
    across = np.repeat(x, study.trials)
    axes.plot(across, cells.ravel(), linestyle="", marker=marker, color=color, markersize=3.5)


def letter(place: int) -> str:
    """Return the letters of an operator: A to Z, then AA."""
    return (letter(place // 26 - 1) if place >= 26 else "") + chr(ord("A") + place % 26)  # noqa: PLR2004  (letters of the alphabet)
