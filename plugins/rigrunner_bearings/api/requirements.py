"""What an analysis of torque and its plugins need of a run, beside what any analysis may ask.

Each number by which the analysis refuses a run is defined only here, or in the plugin that it
belongs to.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

from rigrunner.api import Requirements
from rigrunner.api.analysis.requirements import LEAST_CYCLES

LEAST_CYCLES_WITH_RULE = 2 * LEAST_CYCLES
"""Cycles to record where a rule for gross errors is used: it may reject half of them."""
LEAST_STARTS = 3
"""Starts from rest at one speed and load: with fewer there is no scatter to speak of."""
LEAST_REST_S = 0.1
"""Rest at the beginning of a recorded start: with less, the start may have been missed."""
LEAST_SAMPLES_PER_CYCLE = 16
"""Samples in a cycle: with fewer, cycles and reversals cannot be told apart from noise."""


@dataclass(frozen=True, kw_only=True)
class TorqueRequirements(Requirements):
    """What a compensation needs of a run, from its settings alone.

    Its `cycles` are those of swings; of starts from rest, the starts at each speed and load. Its
    `points` are different frequencies without load. The defaults ask for nothing.
    """

    starts: bool | None = None
    """True: the recordings must be starts from rest. False: swings. None: either will do."""
    phase: bool = False
    """Whether each recording, of the no-load run too, needs a channel that shows the crank phase:
    an angle, an angular velocity, or a channel called 'index'."""
    fit: bool = False
    """Whether the procedure must name a fit."""
    frequency_match: float | None = None
    """How far, relatively, the no-load frequency of each loaded one may be; None: no pairs."""
    within_no_load_range: bool = False
    """Whether each frequency must lie within the range of those without load."""

    @classmethod
    def of(cls, needs: Requirements) -> TorqueRequirements:
        """Return the requirements of any plugin as those of one on torque."""
        if isinstance(needs, cls):
            return needs
        return cls(**{field.name: getattr(needs, field.name) for field in fields(Requirements)})
