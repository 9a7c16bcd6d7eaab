"""Control charts of what an archive holds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.api.studies import Trend
from rigrunner.monitoring.observing import of_one_kind
from rigrunner.trends.charting import charted

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.monitoring.observing import Observations
    from rigrunner.monitoring.quantities import Quantity
    from rigrunner.trends.charting import Charting


def trend(
    quantity: Quantity, found: Observations, how: Charting, asked: Mapping[str, str]
) -> Trend:
    """Return the chart of each group; raise DataError where none can be made."""
    series, refused, hint = [], {}, ""
    for name, group in sorted(found.groups.items()):
        try:
            of_one_kind(group, quantity)
            series.append(charted(name, group.observed, how))
        except DataError as error:
            refused[name], hint = error.message, error.hint
    if not series:
        told = "; ".join(f"{name}: {reason}" for name, reason in refused.items())
        raise DataError(f"no chart can be made. {told}", hint=hint)
    return Trend(
        quantity=quantity.name,
        unit=found.unit,
        asked=asked,
        excluded=found.excluded,
        warnings=found.warnings,
        chart=how.chart,
        rules=how.rule_texts(),
        series=tuple(series),
        not_charted=refused,
    )
