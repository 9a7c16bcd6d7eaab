"""The figures of a capability and of a gauge study.

Names of people and parts are on the page, not in figures, whose font lacks many letters: there
parts have numbers and operators letters.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.figures import Axis, Figure, Mark, Picture, Series
from rigrunner_reports.numbers import as_scattered, fixed

if TYPE_CHECKING:
    from rigrunner.api.studies import CapabilitySeries, CapabilityStudy, GaugeStudy


def distribution(study: CapabilityStudy, series: CapabilitySeries) -> Picture:
    """Return the figure of the values of one group, with the limits and the normal curve."""
    values = np.array([run.value for run in series.observed])
    mean, deviation = series.capability.mean, series.capability.standard_deviation
    limits = [limit for limit in (series.lower, series.upper) if limit is not None]
    low, high = min(values.min(), *limits), max(values.max(), *limits)
    x = np.linspace(min(low, mean - 4 * deviation), max(high, mean + 4 * deviation), 300)

    density, edges = np.histogram(values, bins="auto", density=True)
    curve = np.exp(-0.5 * ((x - mean) / deviation) ** 2) / (deviation * np.sqrt(2 * np.pi))
    figure = Figure(
        "",
        Axis("value", study.unit),
        Axis("density", low=0.0),
        (
            Series.over(x, curve, "normal, of their mean and deviation", "line"),
            Series.over((edges[1:] + edges[:-1]) / 2, density, "values", "bars"),
        ),
        tuple(
            Mark("x", limit, name=f"limit {limit:g} {study.unit}", is_limit=True)
            for limit in limits
        ),
    )
    return Picture(
        caption=f"{series.name}. The values, and the normal curve that the indices rest on.",
        alt=f"{len(values)} values from {as_scattered(values.min(), deviation)} to "
        f"{as_scattered(values.max(), deviation)}, mean {as_scattered(mean, deviation)}.",
        panels=(figure,),
    )


def readings(study: GaugeStudy) -> Picture:
    """Return the figure of all readings, by part and operator."""
    series = []
    room = 0.6 / len(study.operators)
    for place in range(len(study.operators)):
        offset = (place - (len(study.operators) - 1) / 2) * room
        cells = np.array([part[place] for part in study.readings])
        x, name = np.arange(len(study.parts)) + offset, letter(place)
        series.append(Series.over(np.repeat(x, study.trials), cells.ravel(), name))
        series.append(Series.over(x, cells.mean(axis=1), name, "line"))
    figure = Figure(
        "",
        Axis("part", ticks=tuple((place, f"{place + 1}") for place in range(len(study.parts)))),
        Axis("value", study.unit),
        tuple(series),
    )
    u = study.analysis.components
    return Picture(
        caption="All readings. Operators are side by side within a part; the line joins the mean "
        "of each operator's readings. Lines that run apart or cross show operators that measure "
        "parts differently; points far apart show a gauge that does not repeat.",
        alt=f"Readings of {len(study.parts)} parts by {len(study.operators)} operators. Standard "
        f"deviation of the gauge {fixed(u.gauge, 5)}, of the parts {fixed(u.part, 5)} "
        f"{study.unit}.",
        panels=(figure,),
    )


def components(study: GaugeStudy) -> Picture:
    """Return the figure of the components of the total variation."""
    deviations = study.analysis.components
    parts = {
        "gauge R&R": deviations.gauge,
        "repeatability": deviations.repeatability,
        "reproducibility": deviations.reproducibility,
        "part": deviations.part,
    }

    share = np.array(list(parts.values())) / deviations.total
    place = range(len(parts))
    figure = Figure(
        "",
        Axis("component", ticks=tuple(enumerate(parts))),
        Axis("share", "%", low=0.0, high=105.0),
        (
            Series.over(place, 100 * share**2, "% of variance", "bars"),
            Series.over(place, 100 * share, "% of deviation"),
        ),
    )
    shares = ", ".join(
        f"{name} {fixed(100 * s / deviations.total, 1)} %" for name, s in parts.items()
    )
    return Picture(
        caption="What the total variation consists of. Variances add up; deviations do not.",
        alt=f"Share of the total standard deviation: {shares}.",
        panels=(figure,),
    )


def letter(place: int) -> str:
    """Return the letters of an operator: A to Z, then AA."""
    return (letter(place // 26 - 1) if place >= 26 else "") + chr(ord("A") + place % 26)  # noqa: PLR2004  (letters of the alphabet)
