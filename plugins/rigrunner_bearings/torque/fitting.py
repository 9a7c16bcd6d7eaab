"""The curves of peak torque over frequency that a procedure asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DataError
from rigrunner_bearings.api.torque import FittedTorque
from rigrunner_bearings.signal.peaks import peak_points

if TYPE_CHECKING:
    from rigrunner.api import Curve, Fit, Points
    from rigrunner.api.analysis_context import Plugins
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.torque.settings import TorqueSettings


def fitted(
    spec: TorqueSettings, plugins: Plugins, points: tuple[PeakPoint, ...]
) -> tuple[FittedTorque, ...]:
    """Return every fit of the procedure through the peaks; one that failed says why."""
    peaks = peak_points(points)
    return tuple(
        _fitted(each.label, plugins.make("fit", each.name, each.settings), peaks)
        for each in spec.fits
    )


def first_fit(spec: TorqueSettings, plugins: Plugins) -> Fit:
    """Return the fit that compensations take; without any, one that raises DataError."""
    if not spec.fits:
        return _no_fit
    first = spec.fits[0]
    return plugins.make("fit", first.name, first.settings)  # type: ignore[no-any-return]  # a fit


def _fitted(name: str, fit: Fit, points: Points) -> FittedTorque:
    try:
        return FittedTorque(name, points, fit(points))
    except DataError as error:
        return FittedTorque(name, points, None, problem=str(error))


def _no_fit(points: Points) -> Curve:  # noqa: ARG001  (a fit takes points)
    raise DataError("the procedure names no fit", hint="add one under analysis: fits:")
