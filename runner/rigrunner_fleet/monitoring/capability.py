"""The capability of results in an archive, against limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scipy import stats

from rigrunner.api.errors import DataError
from rigrunner.api.studies import CapabilitySeries, CapabilityStudy
from rigrunner_fleet.monitoring.observing import each_group
from rigrunner_fleet.trends.capability import capability
from rigrunner_fleet.trends.charting import Baseline, Charting, charted

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.studies import Observed
    from rigrunner_fleet.monitoring.observing import Bounds, Group, Observations

_GIVE = "give the limits: --upper, --lower"
_NOT_NORMAL = 0.01
"""Below this p-value of Shapiro and Wilk, values are reported as not normal."""


def capability_study(
    found: Observations,
    asked: Mapping[str, str],
    *,
    lower: float | None,
    upper: float | None,
    confidence: float = 0.95,
) -> CapabilityStudy:
    """Return the capability of each group; raise DataError if there is none.

    Without given limits each group has those of its runs.
    """
    series, refused = each_group(
        found,
        lambda name, group: _series(name, group, _limits(group, lower, upper), confidence),
        "no capability can be stated",
    )
    return CapabilityStudy(
        quantity=found.quantity.name,
        unit=found.unit,
        asked=asked,
        excluded=found.excluded,
        warnings=found.warnings,
        lower=lower,
        upper=upper,
        series=series,
        not_stated=refused,
    )


def _series(name: str, group: Group, limits: Bounds, confidence: float) -> CapabilitySeries:
    values = [each.value for each in group.observed]
    lower, upper = limits
    found = capability(values, lower=lower, upper=upper, confidence=confidence)
    warnings = tuple(_warnings(group.observed))
    return CapabilitySeries(name, tuple(group.observed), found, warnings, lower, upper)


def _limits(group: Group, lower: float | None, upper: float | None) -> Bounds:
    """Return the given limits, or else those of the runs, which must be equal."""
    if lower is not None or upper is not None:
        return lower, upper
    if len(group.limits) > 1:
        words = []
        for (low, high), count in sorted(group.limits.items(), key=str):
            given = [] if low is None else [f"{low:.12g} or more"]
            given += [] if high is None else [f"{high:.12g} or less"]
            words.append(f"{count} with {' and '.join(given) or 'none'}")
        known = "; ".join(words)
        raise DataError(f"the runs have several limits: {known}", hint=_GIVE)
    (found,) = group.limits
    if found == (None, None):
        raise DataError("the runs have no limit of it", hint=_GIVE)
    return found


def _warnings(observed: Sequence[Observed]) -> list[str]:
    found = []
    values = [each.value for each in observed]
    chart = charted("", observed, Charting(baseline=Baseline(len(values))))
    met = sum(1 for each in chart.points if each.rules)
    if met:
        found.append(
            f"the process was not in control: a Nelson rule is met at {met} of {len(values)} "
            "values. The indices describe the past, not the future (ISO 22514-1: performance, "
            "Pp and Ppk, instead of capability)"
        )
    p = float(stats.shapiro(values).pvalue)
    if p < _NOT_NORMAL:
        found.append(
            f"the values are not normal (Shapiro and Wilk: p = {p:.2g}): the indices and their"
            " intervals are not valid as stated"
        )
    return found
