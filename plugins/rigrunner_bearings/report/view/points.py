"""The set-points of a run, each with the results of all methods and the simulated truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.signal.peaks import mean_peak

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigrunner.api import Array, ReportInput
    from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation, Trace
    from rigrunner_bearings.api.points import PeakPoint

NEWTON_METRES = "_nm"


@dataclass(frozen=True, eq=False)
class SetPoint:
    """One set-point of the run; `truth_nm` is None on a real rig."""

    point: PeakPoint
    by_method: Mapping[str, CompensatedPoint]
    truth: Mapping[str, float]
    truth_nm: float | None

    @property
    def frequency_hz(self) -> float:
        """The measured frequency."""
        return self.point.frequency_hz.value

    @property
    def swing(self) -> SwingPoint | None:
        """The point with its whole swings; None where nothing shows the phase."""
        return self.point if isinstance(self.point, SwingPoint) else None

    @property
    def kept_peaks_nm(self) -> Array:
        """The raw peaks that the outlier rule kept, shape (kept,)."""
        return self.point.peak_nm[self.point.peak_kept]

    @property
    def raw_peak_nm(self) -> float:
        """The mean of the kept raw peaks."""
        return float(self.kept_peaks_nm.mean())

    @property
    def raw_peak_u_nm(self) -> float:
        """Its type A standard uncertainty (GUM 4.2.3); nan for one peak."""
        return mean_peak(self.point).u


def set_points(report: ReportInput) -> tuple[SetPoint, ...]:
    """Return the set-points of the run as they were recorded."""
    torque = TorqueDetails.of(report.result)
    result = report.result
    primary = torque.compensations.get(torque.primary)
    measurand = result.measurand if primary is None else primary.measurand
    return tuple(
        SetPoint(
            point=point,
            by_method={
                name: compensation.points[place]
                for name, compensation in torque.compensations.items()
                if compensation.points
            },
            truth=report.truth.get(point.recording, {}),
            truth_nm=true_torque(report.truth.get(point.recording, {}), measurand),
        )
        for place, point in enumerate(torque.loaded)
    )


def by_frequency(points: Iterable[SetPoint]) -> list[SetPoint]:
    """Return the set-points in the order of their measured frequency."""
    return sorted(points, key=lambda set_point: set_point.frequency_hz)


def low_middle_high(points: Sequence[SetPoint]) -> list[SetPoint]:
    """Return the set-points of lowest, middle and highest frequency; fewer if there are fewer."""
    ordered = by_frequency(points)
    return [ordered[i] for i in sorted({0, len(ordered) // 2, len(ordered) - 1}) if ordered]


def traces(points: Sequence[SetPoint], method: str) -> list[tuple[float, Trace]]:
    """Return (frequency, trace) of a method at low, middle and high frequency."""
    traced = [set_point for set_point in points if _trace(set_point, method) is not None]
    return [
        (set_point.frequency_hz, trace)
        for set_point in low_middle_high(traced)
        if (trace := _trace(set_point, method)) is not None
    ]


def true_torque(truth: Mapping[str, float], measurand: str) -> float | None:
    """Return the true value of the measurand in N·m, if the simulator knows it.

    The truth 'starting_torque_nm' belongs to every measurand that has the words 'starting torque'
    in its name: a running torque is another quantity and has no error against it. The name is that
    of the method, never the procedure's, which may be in any language.
    """
    for name, value in truth.items():
        words = name.removesuffix(NEWTON_METRES).replace("_", " ")
        if name.endswith(NEWTON_METRES) and words in measurand.lower():
            return value
    return None


def true_parameter(points: Iterable[SetPoint], name: str) -> float | None:
    """Return the true value of a rig's parameter such as 'natural frequency', if all points agree.

    The truth's names end in the unit: natural_frequency_hz.
    """
    stem = name.lower().replace(" ", "_")
    values = {
        value
        for set_point in points
        for key, value in set_point.truth.items()
        if key == stem or key.startswith(f"{stem}_")
    }
    return values.pop() if len(values) == 1 else None


def error(set_point: SetPoint, name: str, compensation: Compensation) -> float | None:
    """Return a method's value minus the truth of what it measures, in N·m, or None."""
    truth = true_torque(set_point.truth, compensation.measurand)
    result = set_point.by_method.get(name)
    return None if truth is None or result is None else result.torque.value - truth


def _trace(set_point: SetPoint, method: str) -> Trace | None:
    result = set_point.by_method.get(method)
    return result.trace if result else None
