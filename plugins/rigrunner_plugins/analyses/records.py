"""The analyses of any quantity that ship, as records. Their settings load once they are named."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import AnalysisRecord, hookimpl

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api.findings import Analysis, NeededChannel, Objection, ResultDefinition
    from rigrunner_plugins.analyses.settings import ReadingsSettings


@hookimpl
def rigrunner_analyses() -> list[AnalysisRecord]:
    """Return the analyses."""
    return [
        AnalysisRecord(
            name="readings",
            help="A statistic of recorded or measured values, with its uncertainty",
            settings="rigrunner_plugins.analyses.settings:ReadingsSettings",
            factory=_readings,
            yields=_yields,
            requires=_requires,
            objections=_objections,
            trial={
                "of": "meter.voltage",
                "per": ["load.current"],
                "result": {"name": "voltage", "symbol": "U", "unit": "V"},
            },
            trial_units={"meter.voltage": "V"},
        )
    ]


def _readings(settings: ReadingsSettings) -> Analysis:
    from rigrunner_plugins.analyses.readings import Readings  # noqa: PLC0415  (numpy)

    return Readings(settings)


def _yields(settings: ReadingsSettings) -> tuple[ResultDefinition, ...]:
    return settings.yields()


def _requires(settings: ReadingsSettings) -> tuple[NeededChannel, ...]:
    return settings.requires()


def _objections(settings: ReadingsSettings, units: Mapping[str, str]) -> Iterable[Objection]:
    return settings.objections(units)
