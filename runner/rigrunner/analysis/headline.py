"""The one number of a run: the mean over its set-points, with what they have in common."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner.signal.mean_model import mean_model
from rigrunner.signal.peaks import mean_peak
from rigrunner.signal.propagation import propagate
from rigrunner.signal.sensor import reading_components
from rigrunner.signal.uncertainty import combine

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api.analysis import CompensatedPoint, PeakPoint
    from rigrunner.api.instruments import TorqueInstrument


def compensated_mean(points: Sequence[CompensatedPoint]) -> Estimate:
    """Return the mean of the compensated torque over the set-points."""
    return propagate(mean_model(points)).estimate


def raw_peak_mean(
    points: Sequence[PeakPoint], instrument: TorqueInstrument, *, zeroed: bool
) -> Estimate:
    """Return the mean over the set-points of the raw peaks, with the sensor's uncertainty."""
    peaks = [mean_peak(point) for point in points]
    components = [
        (*scatter, *reading_components(instrument, value, zeroed=zeroed))
        for value, scatter in peaks
    ]
    return _mean([value for value, _ in peaks], components)


def _mean(values: Sequence[float], components: Sequence[Iterable[Component]]) -> Estimate:
    """Return the mean: common errors shift all set-points alike and stay, the others average."""
    count = len(values)
    shared: dict[str, list[Component]] = defaultdict(list)
    parts: list[Component] = []
    for component in (part for point in components for part in point):
        if component.common:
            shared[component.name].append(component)
        else:
            parts.append(_scaled(component, component.u / count))
    parts += [_scaled(same[0], sum(part.u for part in same) / count) for same in shared.values()]
    u, dof = combine(parts)
    return Estimate(float(np.mean(values)), u, dof)


def _scaled(component: Component, u: float) -> Component:
    return Component(component.name, u, component.dof, component.distribution, component.common)
