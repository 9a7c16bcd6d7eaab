"""Starting torque by the recorded template: the no-load run of the same frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_bearings.compensations.bearing import mean_swing
from rigrunner_bearings.compensations.inverse import Inverse
from rigrunner_bearings.compensations.matching import pairs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner_bearings.api.compensations import SwingSweep
    from rigrunner_bearings.compensations.bearing import MeanSwing
    from rigrunner_bearings.compensations.identification import Identified
    from rigrunner_bearings.compensations.settings import TemplateInverseSettings


@dataclass(frozen=True)
class TemplateInverse(Inverse):
    """The compensation `template_inverse`: raises DataError for a frequency without no-load run."""

    settings: TemplateInverseSettings

    def templates(self, sweep: SwingSweep, rig: Identified) -> Sequence[MeanSwing]:
        """Return the mean swing of each loaded point's partner."""
        matched = pairs(sweep, self.settings.frequency_match)
        return [mean_swing(no_load, rig.friction.swing.size) for _, no_load in matched]
