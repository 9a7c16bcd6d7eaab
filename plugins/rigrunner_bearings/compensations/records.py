"""The compensations that ship with Rigrunner. Nothing here loads numpy."""

from __future__ import annotations

from rigrunner.api import Imported, KindRecord, hookimpl
from rigrunner_bearings.api import CompensationRecord
from rigrunner_bearings.api.measurand import Condition, MeasurandKind, Nature
from rigrunner_bearings.compensations import requirements

RIG = "rigrunner_bearings.api.rig:RigDescription"
"""What the station may say of a rig that swings or turns bearings."""
STARTING = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)
RUNNING = MeasurandKind(Nature.LOAD_INDUCED, Condition.UNDER_WAY)
OTHER_PHASE = (
    "the loaded and the no-load peak fall at different phases of the swing, and the uncertainty"
    " does not include what comes of that"
)
BREAKAWAY = MeasurandKind(Nature.TOTAL, Condition.FROM_REST)


@hookimpl
def rigrunner_kinds() -> list[KindRecord]:
    """Return the kind of plugins that this package brings."""
    return [
        KindRecord(
            name="compensation",
            help="A way to subtract the rig's no-load torque from the measured torque",
            hook="rigrunner_compensations",
            record=CompensationRecord,
            takes=("sweep",),
            conformance="rigrunner_bearings.conformance",
            template="rigrunner_bearings:plugin_template",
        )
    ]


@hookimpl
def rigrunner_compensations() -> list[CompensationRecord]:
    """Return the ways to subtract the no-load torque of the rig from the measured torque."""
    return [
        CompensationRecord(
            name="paper_peak",
            help="Raw peak minus fitted no-load peak, as published (Eq. 2)",
            settings="rigrunner_bearings.compensations.settings:PaperPeakSettings",
            rig=RIG,
            factory=Imported("rigrunner_bearings.compensations.paper_peak:PaperPeak"),
            requires=requirements.of_paper_peak,
            yields=STARTING,
            not_covered=OTHER_PHASE,
        ),
        CompensationRecord(
            name="peak_same_frequency",
            help="Raw peak minus the no-load peak of the same frequency",
            settings="rigrunner_bearings.compensations.settings:PeakSameFrequencySettings",
            rig=RIG,
            factory=Imported(
                "rigrunner_bearings.compensations.peak_same_frequency:PeakSameFrequency"
            ),
            requires=requirements.of_peak_same_frequency,
            yields=STARTING,
            not_covered=OTHER_PHASE,
        ),
        CompensationRecord(
            name="template_inverse",
            help="Whole swings: loaded minus no-load, resonance and filter undone (recommended)",
            settings="rigrunner_bearings.compensations.settings:TemplateInverseSettings",
            rig=RIG,
            factory=Imported("rigrunner_bearings.compensations.inverse:TemplateInverse"),
            requires=requirements.of_template_inverse,
            yields=STARTING,
            revision=4,
        ),
        CompensationRecord(
            name="model_inverse",
            help="As template_inverse, with a model of the no-load sweep: also between its "
            "frequencies",
            settings="rigrunner_bearings.compensations.settings:InverseSettings",
            rig=RIG,
            factory=Imported("rigrunner_bearings.compensations.inverse:ModelInverse"),
            requires=requirements.of_model_inverse,
            yields=STARTING,
            revision=4,
        ),
        CompensationRecord(
            name="energy",
            help="Running torque: work of a swing divided by its travel, loaded minus no-load",
            settings="rigrunner_bearings.compensations.settings:EnergySettings",
            rig=RIG,
            factory=Imported("rigrunner_bearings.compensations.energy:Energy"),
            requires=requirements.of_energy,
            yields=RUNNING,
            revision=3,
        ),
        CompensationRecord(
            name="breakaway_peak",
            help="Starts from rest: mean of their breakaway torques",
            settings="rigrunner_bearings.compensations.settings:BreakawayPeakSettings",
            rig=RIG,
            factory=Imported("rigrunner_bearings.compensations.breakaway_peak:BreakawayPeak"),
            requires=requirements.of_breakaway_peak,
            yields=BREAKAWAY,
        ),
    ]
