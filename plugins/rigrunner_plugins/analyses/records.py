"""The analyses of any quantity that ship, as records. Loads without numpy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import AnalysisRecord, hookimpl
from rigrunner_plugins.analyses import settings

if TYPE_CHECKING:
    from rigrunner.api.findings import Analysis


@hookimpl
def rigrunner_analyses() -> list[AnalysisRecord]:
    """Return the analyses."""
    return [
        AnalysisRecord(
            name="readings",
            help="A statistic of recorded or measured values, with its uncertainty",
            settings=settings.ReadingsSettings,
            factory=_readings,
            requires=settings.requires,
            yields=settings.yields,
            objections=settings.objections,
            trial={
                "of": "meter.voltage",
                "per": ["load.current"],
                "result": {"name": "voltage", "symbol": "U", "unit": "V"},
            },
            trial_units={"meter.voltage": "V"},
        )
    ]


def _readings(told: settings.ReadingsSettings) -> Analysis:
    from rigrunner_plugins.analyses.readings import Readings  # noqa: PLC0415  (numpy)

    return Readings(told)
