"""The capability of results in an archive, against limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scipy import stats

from rigrunner.api.errors import DataError
from rigrunner.api.studies import CapabilitySeries, CapabilityStudy
from rigrunner_fleet.monitoring.observing import study_groups
from rigrunner_fleet.trends.capability import capability
from rigrunner_fleet.trends.charting import Baseline, Charting, control_chart
from rigrunner_fleet.trends.charts import FEWEST

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.studies import Observed
    from rigrunner_fleet.monitoring.observing import Bounds, Group, Observations

_GIVE = "give the limits: --upper, --lower"
_NOT_NORMAL = 0.01
"""Below this p-value of Shapiro and Wilk, values are reported as not normal."""


def capability_study(
    observations: Observations,
    asked: Mapping[str, str],
    *,
    lower: float | None,
    upper: float | None,
    confidence: float = 0.95,
) -> CapabilityStudy:
    """Return the capability of each group; raise DataError if there is none.

    Without given limits each group has those of its runs.
    """
    series, refused = study_groups(
        observations,
        lambda name, group: _series(name, group, _limits(group, lower, upper), confidence),
        "no capability can be stated",
    )
    return CapabilityStudy(
        quantity=observations.quantity.name,
        unit=observations.unit,
        asked=asked,
        excluded=observations.excluded,
        warnings=observations.warnings,
        lower=lower,
        upper=upper,
        series=series,
        not_stated=refused,
    )


def _series(name: str, group: Group, limits: Bounds, confidence: float) -> CapabilitySeries:
    values = [observation.value for observation in group.observed]
    lower, upper = limits
    indices = capability(values, lower=lower, upper=upper, confidence=confidence)
    warnings = tuple(_warnings(group.observed))
    return CapabilitySeries(name, tuple(group.observed), indices, warnings, lower, upper)


def _limits(group: Group, lower: float | None, upper: float | None) -> Bounds:
    """Return the given limits, or else those of the runs, which must be equal."""
    if lower is not None or upper is not None:
        return lower, upper
    if len(group.limits) > 1:
        counts = []
        for (low, high), count in sorted(group.limits.items(), key=str):
            bounds = [] if low is None else [f"{low:.12g} or more"]
            bounds += [] if high is None else [f"{high:.12g} or less"]
            counts.append(f"{count} with {' and '.join(bounds) or 'none'}")
        all_limits = "; ".join(counts)
        raise DataError(f"the runs have several limits: {all_limits}", hint=_GIVE)
    (limits,) = group.limits
    if limits == (None, None):
        raise DataError("the runs have no limit of it", hint=_GIVE)
    return limits


def _warnings(observed: Sequence[Observed]) -> list[str]:
    if len(observed) < FEWEST:
        what = "whether the process is in control and normal"
        return [f"{len(observed)} values do not show {what}, {FEWEST} would: preliminary indices"]
    warnings = []
    values = [observation.value for observation in observed]
    chart = control_chart("", observed, Charting(baseline=Baseline(len(values))))
    met = sum(1 for point in chart.points if point.rules)
    if met:
        warnings.append(
            f"the process was not in control: a Nelson rule is met at {met} of {len(values)} "
            "values. The indices describe the past, not the future (ISO 22514-1: performance, "
            "Pp and Ppk, instead of capability)"
        )
    p = float(stats.shapiro(values).pvalue)
    if p < _NOT_NORMAL:
        warnings.append(
            f"the values are not normal (Shapiro and Wilk: p = {p:.2g}): the indices and their"
            " intervals are not valid as stated"
        )
    return warnings
