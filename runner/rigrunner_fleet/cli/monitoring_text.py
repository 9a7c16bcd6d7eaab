"""Trends, capabilities and gauge studies, as text for a terminal."""

from __future__ import annotations

from collections import Counter
from math import isfinite
from typing import TYPE_CHECKING

from rigrunner.api.summaries import pairs, table
from rigrunner.signal.rounding import places

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.studies import (
        CapabilitySeries,
        CapabilityStudy,
        GaugeStudy,
        Known,
        Study,
        Trend,
        TrendSeries,
    )

_SHOWN = 20
"""Alarms of a series that are listed; the rest is counted."""


def trend_text(trend: Trend) -> str:
    """Return the limits of each chart, and where a rule is met."""
    lines = [f"{trend.quantity} / {trend.unit}, {trend.chart} chart"]
    for series in trend.series:
        lines += ["", *_series(series, trend)]
    lines += _left_out(trend, "No chart of", trend.not_charted)
    return "\n".join(lines)


def capability_text(study: CapabilityStudy) -> str:
    """Return the indices of each group with their intervals."""
    limits = _limits(study, study.unit) or ["with the limits of the runs"]
    lines = [f"{study.quantity} / {study.unit}, {', '.join(limits)}"]
    for series in study.series:
        lines += ["", *_capability(series, study.unit)]
    lines += _left_out(study, "No capability of", study.not_stated)
    return "\n".join(lines)


def gauge_text(study: GaugeStudy) -> str:
    """Return the table of the analysis of variance, and the components."""
    rows = [
        [
            row.source,
            str(row.degrees_of_freedom),
            f"{row.sum_of_squares:.6g}",
            f"{row.mean_square:.6g}",
            "" if row.f is None else f"{row.f:.2f}",
            "" if row.p is None else f"{row.p:.3f}",
        ]
        for row in study.analysis.table
    ]
    header = ["source", "dof", "sum of squares", "mean square", "F", "p"]
    size = f"{len(study.parts)} parts x {len(study.operators)} operators x {study.trials} trials"
    lines = [f"{study.quantity} / {study.unit}, {size}", "", table(header, rows, "lrrrrr"), ""]
    lines += [_components(study), "", *_verdicts(study), *_station_lines(study)]
    lines += _left_out(study, "", {})
    return "\n".join(lines)


def _station_lines(study: GaugeStudy) -> Iterator[str]:
    """Yield the lines with which a station names a study of the torque, so that it enters U."""
    if study.quantity != "torque":
        return
    components, intervals = study.analysis.components, study.analysis.known
    procedure = f"{study.asked['procedure']}, " if "procedure" in study.asked else ""
    size = f"{len(study.parts)} parts, {len(study.operators)} operators, {study.trials} trials"
    yield from ("In the station, so that it enters U of every result:", "", "rig:")
    yield "  gauge_study:"
    yield f'    source: "{procedure}{size}"'
    for name, key, u in (
        ("between_mountings", "repeatability", components.repeatability),
        ("reproducibility", "reproducibility", components.reproducibility),
    ):
        if u > 0:
            dof = max(1.0, intervals[key].degrees_of_freedom)
            yield f"    {name}: {{u: {1000 * u:.3g} mN·m, degrees_of_freedom: {dof:.3g}}}"
    yield ""


def number(value: float, width: float) -> str:
    """Return a value with as many decimals as its scatter justifies."""
    return f"{value:.{max(0, places(width, 2) + 1)}f}" if isfinite(value) else str(value)


def _series(series: TrendSeries, trend: Trend) -> Iterator[str]:
    limits, ranges = series.individuals, series.moving_range
    first, last = series.points[0], series.points[-1]
    base = [point.observed for point in series.points if point.baseline]
    sigma = limits.sigma
    yield series.name
    expanded = sorted(point.observed.expanded for point in series.points if point.observed.expanded)
    stated = f"{expanded[len(expanded) // 2]:.2g}, the median" if expanded else "none"
    yield pairs(
        [
            ("  runs", f"{len(series.points)}, {first.observed.run_id} to {last.observed.run_id}"),
            ("  baseline", f"{len(base)}, {base[0].run_id} to {base[-1].run_id}"),
            ("  centre", number(limits.centre, sigma)),
            ("  limits", f"{number(last.lower, sigma)} to {number(last.upper, sigma)}"),
            ("  moving range", f"up to {number(ranges.upper, ranges.sigma)}"),
            ("  stated U", stated),
            ("  correlation", f"{series.lag_one:.2f} between neighbours of the baseline"),
        ]
    )
    yield from (f"  note: {text}" for text in series.warnings)
    if not series.after:
        yield "  No value after the baseline yet."
    elif not series.alarms:
        yield f"  In control: no rule is met at {len(series.after)} values after the baseline."
    else:
        yield f"  OUT OF CONTROL at {len(series.alarms)} of {len(series.after)} values:"
        yield from _alarms(series, trend)


def _alarms(series: TrendSeries, trend: Trend) -> Iterator[str]:
    sigma = series.individuals.sigma
    for point in series.alarms[:_SHOWN]:
        rules = ", ".join(point.rules)
        yield f"    {point.observed.run_id}  {number(point.observed.value, sigma)}  {rules}"
    if len(series.alarms) > _SHOWN:
        yield f"    and {len(series.alarms) - _SHOWN} more"
    met = {rule for point in series.alarms for rule in point.rules}
    yield from (f"    {name}: {text}" for name, text in trend.rules.items() if name in met)


def _limits(study: CapabilityStudy | CapabilitySeries, unit: str) -> list[str]:
    """Return the limits as text."""
    limits = ("lower limit", study.lower), ("upper limit", study.upper)
    return [f"{name} {value:.12g} {unit}" for name, value in limits if value is not None]


def _capability(series: CapabilitySeries, unit: str) -> Iterator[str]:
    capability = series.capability
    deviation = capability.standard_deviation
    low, high = (number(end, deviation) for end in capability.mean_interval)
    least, most = capability.deviation_interval
    yield series.name
    yield pairs(
        [
            ("  runs", str(capability.count)),
            ("  limits", ", ".join(_limits(series, unit))),
            ("  mean", f"{number(capability.mean, deviation)}, from {low} to {high}"),
            ("  deviation", f"{deviation:.3g}, from {least:.3g} to {most:.3g}"),
            ("  confidence", f"{100 * capability.confidence:g} %"),
            *(
                (f"  {index.name}", f"{index.value:.2f}, from {index.low:.2f} to {index.high:.2f}")
                for index in capability.indices
            ),
        ]
    )
    yield from (f"  note: {text}" for text in series.warnings)


def _components(study: GaugeStudy) -> str:
    components = study.analysis.components
    header = ["component", "deviation", "% of variance", "% of total", "95 % interval, dof"]
    parts = [
        ("gauge R&R", components.gauge, "gauge"),
        ("  repeatability", components.repeatability, "repeatability"),
        ("  reproducibility", components.reproducibility, "reproducibility"),
        ("    operator", components.operator, "operator"),
        ("    part x operator", components.interaction, "interaction"),
        ("part", components.part, "part"),
        ("total", components.total, ""),
    ]
    rows = [
        [
            name,
            f"{s:.4g}",
            f"{100 * s**2 / components.total**2:.1f}",
            f"{100 * s / components.total:.1f}",
            _interval(study.analysis.known.get(key)),
        ]
        for name, s, key in parts
    ]
    if study.tolerance is not None:
        header.append("% of tolerance")
        # Six standard deviations over the tolerance, in percent (AIAG MSA).
        rows = [
            [*row, f"{600 * s / study.tolerance:.1f}"]
            for row, (_, s, _) in zip(rows, parts, strict=True)
        ]
    return table(header, rows, "lrrrlr"[: len(header)])


def _interval(interval: Known | None) -> str:
    if interval is None:
        return ""
    return f"{interval.low:.3g} to {interval.high:.3g}, {interval.degrees_of_freedom:.3g}"


def _verdicts(study: GaugeStudy) -> Iterator[str]:
    categories = study.analysis.components.distinct_categories
    shown = f"{int(categories)}" if isfinite(categories) else "any number of"
    yield f"{shown} distinct categories (5 or more are advised: AIAG MSA)"
    if study.analysis.pooled:
        yield "The interaction is pooled with the repeatability: its p-value is above 0.25."
    if study.expanded is not None:
        yield f"The stated U of a reading is {study.expanded:.2g} {study.unit}, the median."


def _left_out(study: Study, title: str, groups: Mapping[str, str]) -> list[str]:
    lines = [f"{title} {name}: {reason}" for name, reason in groups.items()]
    lines += [f"note: {text}" for text in study.warnings]
    reasons = Counter(run.reason for run in study.excluded)
    lines += [f"{count} left out: {reason}" for reason, count in reasons.most_common()]
    return ["", *lines] if lines else []
