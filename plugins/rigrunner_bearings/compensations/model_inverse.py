"""Starting torque by a modelled template: what the whole no-load sweep says of each frequency.

For frequencies that the sweep does not have; it also averages the noise of the template over all of
them. A rig that does not follow the model (see the check 'drive line') is served better by
`template_inverse`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_bearings.compensations.inverse import Inverse
from rigrunner_bearings.compensations.model_template import no_load_model

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner_bearings.api.compensations import SwingSweep
    from rigrunner_bearings.compensations.bearing import MeanSwing
    from rigrunner_bearings.compensations.identification import Identified


class ModelInverse(Inverse):
    """The compensation `model_inverse`: raises DataError for a frequency outside of the sweep."""

    def templates(self, sweep: SwingSweep, rig: Identified) -> Sequence[MeanSwing]:
        """Return the model's torque at each loaded point's measured frequency."""
        model = no_load_model(sweep.no_load, rig)
        return [model.template(point.frequency_hz.value) for point in sweep.loaded]
