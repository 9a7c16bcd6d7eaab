"""The rules for gross errors that ship; each `_name` function is the factory of one record."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import OutlierRuleRecord, hookimpl
from rigrunner_plugins.outlier_rules import requirements
from rigrunner_plugins.outlier_rules.examples import PENDULUM, ROSNER, URANIUM

if TYPE_CHECKING:
    from rigrunner.api import NoSettings, OutlierRule
    from rigrunner_plugins.outlier_rules.settings import (
        GeneralizedEsdSettings,
        GrubbsSettings,
        MadSettings,
    )


@hookimpl
def rigrunner_outlier_rules() -> list[OutlierRuleRecord]:
    """Return the rules for gross errors."""
    return [
        OutlierRuleRecord(
            name="grubbs",
            help="Grubbs' test, repeated until it finds no gross error",
            settings="rigrunner_plugins.outlier_rules.settings:GrubbsSettings",
            factory=_grubbs,
            examples=(URANIUM,),
        ),
        OutlierRuleRecord(
            name="generalized_esd",
            help="Rosner's test for several gross errors, also if they mask each other",
            settings="rigrunner_plugins.outlier_rules.settings:GeneralizedEsdSettings",
            factory=_generalized_esd,
            examples=(ROSNER,),
        ),
        OutlierRuleRecord(
            name="pauta",
            help="The 3-sigma rule, repeated; can reject nothing of 10 cycles or fewer",
            factory=_pauta,
            requires=requirements.of_pauta,
        ),
        OutlierRuleRecord(
            name="chauvenet",
            help="Chauvenet's criterion, once; often rejects a good cycle, too",
            factory=_chauvenet,
            examples=(PENDULUM,),
        ),
        OutlierRuleRecord(
            name="mad",
            help="Modified z-score from median and median absolute deviation, once",
            settings="rigrunner_plugins.outlier_rules.settings:MadSettings",
            factory=_mad,
        ),
        OutlierRuleRecord(name="none", help="Keep every cycle", factory=_keep_all, rejects=False),
    ]


def _grubbs(settings: GrubbsSettings) -> OutlierRule:
    from rigrunner_plugins.outlier_rules.grubbs import Grubbs  # noqa: PLC0415  (scipy)

    return Grubbs(settings)


def _generalized_esd(settings: GeneralizedEsdSettings) -> OutlierRule:
    from rigrunner_plugins.outlier_rules.generalized_esd import (  # noqa: PLC0415  (scipy)
        GeneralizedEsd,
    )

    return GeneralizedEsd(settings)


def _pauta(_: NoSettings) -> OutlierRule:
    from rigrunner_plugins.outlier_rules.pauta import pauta  # noqa: PLC0415  (scipy)

    return pauta


def _chauvenet(_: NoSettings) -> OutlierRule:
    from rigrunner_plugins.outlier_rules.chauvenet import chauvenet  # noqa: PLC0415  (scipy)

    return chauvenet


def _mad(settings: MadSettings) -> OutlierRule:
    from rigrunner_plugins.outlier_rules.mad import Mad  # noqa: PLC0415  (scipy)

    return Mad(settings)


def _keep_all(_: NoSettings) -> OutlierRule:
    from rigrunner_plugins.outlier_rules.keep_all import keep_all  # noqa: PLC0415  (numpy)

    return keep_all
