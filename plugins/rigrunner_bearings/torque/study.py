"""What a gauge study of the rig adds to the uncertainty of a result.

A run is one mounting by one person: by how much another mounting, or another person, would have
found another torque, the run itself does not show. Both are one and the same at all its points.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api import Distribution, Effect, Input
from rigrunner_bearings.signal.mean_model import with_effects

if TYPE_CHECKING:
    from rigrunner_bearings.api.compensations import Compensation
    from rigrunner_bearings.api.rig import NamedStudy


def with_study(compensation: Compensation, study: NamedStudy | None) -> Compensation:
    """Return a compensation with the scatter of the study in each point; as it is without one."""
    if study is None:
        return compensation
    scatters = (
        ("scatter between mountings", study.between_mountings),
        ("reproducibility", study.reproducibility),
    )
    effects = tuple(
        Effect(
            Input(
                f"{name} ({study.source})",
                0.0,
                scatter.u,
                scatter.degrees_of_freedom,
                Distribution.T,
                common=True,
            ),
            1.0,
        )
        for name, scatter in scatters
        if scatter is not None and scatter.u > 0
    )
    if not effects:
        return compensation
    return replace(
        compensation, points=tuple(with_effects(point, effects) for point in compensation.points)
    )
