"""The rules for gross errors that ship."""

from __future__ import annotations

from rigrunner.api import Imported, OutlierRuleRecord, hookimpl
from rigrunner.api.hooks import OutlierExample
from rigrunner_plugins.outlier_rules.requirements import of_pauta

URANIUM = OutlierExample(
    source="Tietjen and Moore, Technometrics 14(3), 1972, by NIST/SEMATECH 1.3.5.17.1",
    values=(199.31, 199.53, 200.19, 200.82, 201.92, 201.95, 202.18, 245.57),
    rejected=(7,),
    settings={"side": "high"},
)
_ROSNER = (
    -0.25, 0.68, 0.94, 1.15, 1.20, 1.26, 1.26, 1.34, 1.38, 1.43, 1.49, 1.49, 1.55,
    1.56, 1.58, 1.65, 1.69, 1.70, 1.76, 1.77, 1.81, 1.91, 1.94, 1.96, 1.99, 2.06,
    2.09, 2.10, 2.14, 2.15, 2.23, 2.24, 2.26, 2.35, 2.37, 2.40, 2.47, 2.54, 2.62,
    2.64, 2.90, 2.92, 2.92, 2.93, 3.21, 3.26, 3.30, 3.59, 3.68, 4.30, 4.64, 5.34,
    5.42, 6.01,
)  # fmt: skip
ROSNER = OutlierExample(
    source="Rosner, Technometrics 25(2), 1983, by NIST/SEMATECH 1.3.5.17.3",
    values=_ROSNER,
    rejected=(51, 52, 53),
    settings={"at_most": 10},
)
PENDULUM = OutlierExample(
    source="Taylor, An Introduction to Error Analysis, 6.1",
    values=(3.8, 3.5, 3.9, 3.9, 3.4, 1.8),
    rejected=(5,),
)


@hookimpl
def rigrunner_outlier_rules() -> list[OutlierRuleRecord]:
    """Return the rules for gross errors."""
    return [
        OutlierRuleRecord(
            name="grubbs",
            help="Grubbs' test, repeated until it finds no gross error",
            settings="rigrunner_plugins.outlier_rules.settings:GrubbsSettings",
            factory=Imported("rigrunner_plugins.outlier_rules.rules:Grubbs"),
            examples=(URANIUM,),
        ),
        OutlierRuleRecord(
            name="generalized_esd",
            help="Rosner's test for several gross errors, even if they mask each other",
            settings="rigrunner_plugins.outlier_rules.settings:GeneralizedEsdSettings",
            factory=Imported("rigrunner_plugins.outlier_rules.rules:GeneralizedEsd"),
            examples=(ROSNER,),
        ),
        OutlierRuleRecord(
            name="pauta",
            help="The 3-sigma rule, repeated; cannot reject any of 10 cycles or fewer",
            factory=Imported("rigrunner_plugins.outlier_rules.rules:pauta", called=False),
            requires=of_pauta,
        ),
        OutlierRuleRecord(
            name="chauvenet",
            help="Chauvenet's criterion, once; often rejects good cycles",
            factory=Imported("rigrunner_plugins.outlier_rules.rules:chauvenet", called=False),
            examples=(PENDULUM,),
        ),
        OutlierRuleRecord(
            name="mad",
            help="Modified z-score from median and median absolute deviation, once",
            settings="rigrunner_plugins.outlier_rules.settings:MadSettings",
            factory=Imported("rigrunner_plugins.outlier_rules.rules:Mad"),
        ),
        OutlierRuleRecord(
            name="none",
            help="Keep every cycle",
            factory=Imported("rigrunner_plugins.outlier_rules.rules:keep_all", called=False),
            rejects=False,
        ),
    ]
