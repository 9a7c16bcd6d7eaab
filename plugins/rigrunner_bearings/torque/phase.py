"""The effect of an uncertain crank phase on a method's torque.

Where an index pulse or a tacho replaces the angle, or another clock than the torque's sampled it,
the phase is known less well than methods take it to be. Each method is run again with the swings
shifted by that much: the change of its result is its uncertainty, for any use of the swings
(GUM 5.1.3, a sensitivity found by trial).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError, Effect
from rigrunner.signal.inputs import limited
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.signal.mean_model import with_effects
from rigrunner_bearings.torque.clocks import (
    alignment_check,
    alignments,
    refusal,
    shift_rad,
    with_clocks,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.api.compensations import (
        CompensatedPoint,
        Compensation,
        CompensationMethod,
        Sweep,
    )
    from rigrunner_bearings.api.points import PeakPoint

NOTE = (
    "The crank phase is not from an angle channel but from a tacho or an index pulse; how well it "
    "is known so is in the uncertainty."
)
CLOCK_NOTE = (
    "Torque and angle were sampled by two clocks; how well these were aligned is in the "
    "uncertainty."
)
COMMON, OWN = "place of the index or tacho", "time of the index pulse"
ALIGNMENT = "alignment of the clocks"
STEP_RAD = 0.01
"""The greatest shift that is tried: of a greater doubt the effect is taken to grow with it, for a
shift by a whole cycle would seem to have none."""
Doubt = Callable[[SwingPoint], float]
"""A standard uncertainty of the crank phase, in rad."""
Pattern = tuple[int, ...]
ALIKE, OPPOSITE, UNSHIFTED = (1,), (-1,), (0,)
ALTERNATING = ((1, -1), (-1, 1))
"""Which way the points of a run are shifted, over and over."""


def compensated(method: CompensationMethod, sweep: Sweep) -> Compensation:
    """Return the method's result, with the uncertainty of the phase in its own.

    Raises DataError where the method does.
    """
    sources = (*sweep.loaded, *sweep.no_load)
    try:
        compensation = method(sweep)
    except DataError as error:
        raise with_clocks(error, sources) from error
    doubts = (_own_u_rad, _common_u_rad, shift_rad)
    if not any(_is_doubtful(point, doubt) for point in sources for doubt in doubts):
        return compensation
    effects = _Trial(method, sweep, _torques(compensation)).effects()
    if not any(np.any(effect) for effect in effects.values()):
        return compensation
    notes = [NOTE] if np.any(effects[COMMON]) or np.any(effects[OWN]) else []
    if np.any(effects[ALIGNMENT]):
        aligned = alignments(compensation.points, sources, effects[ALIGNMENT])
        check = alignment_check(aligned)
        if not check.ok:
            # Without a result, what was learned of the rig is of no use either.
            empty = replace(compensation, points=(), curve=None, parameters={}, checks=(check,))
            return replace(empty, not_applicable=refusal(aligned))
        compensation = replace(compensation, checks=(*compensation.checks, check))
        notes.append(CLOCK_NOTE)
    points = tuple(
        _with_doubts(point, {name: float(effect[i]) for name, effect in effects.items()})
        for i, point in enumerate(compensation.points)
    )
    return replace(compensation, points=points, notes=(*compensation.notes, *notes))


@dataclass(frozen=True, eq=False)
class _Trial:
    """A method, its sweep, and the torque that it gave, shape (points,)."""

    method: CompensationMethod
    sweep: Sweep
    torque_nm: Array

    def effects(self) -> dict[str, Array]:
        """Return what each kind of doubt moves the torques by, each of shape (points,).

        A common error shifts both runs by the same, and its sign matters. A recording's own error
        shifts it against the other run, and against its neighbours.
        """
        return {
            COMMON: self._greater_effect(_common_u_rad, (ALIKE, ALIKE), (OPPOSITE, OPPOSITE)),
            OWN: self._separate_effect(_own_u_rad),
            ALIGNMENT: self._alignment_effect(),
        }

    def _alignment_effect(self) -> Array:
        points = (*self.sweep.loaded, *self.sweep.no_load)
        times = max(1.0, max(shift_rad(point) for point in points) / STEP_RAD)
        return times * self._separate_effect(lambda point: shift_rad(point) / times)

    def _separate_effect(self, doubt: Doubt) -> Array:
        loaded = self._greater_effect(doubt, *((way, UNSHIFTED) for way in ALTERNATING))
        no_load = self._greater_effect(doubt, *((UNSHIFTED, way) for way in ALTERNATING))
        return np.asarray(np.hypot(loaded, no_load))

    def _greater_effect(self, doubt: Doubt, *ways: tuple[Pattern, Pattern]) -> Array:
        """Return the greater effect of shifts either way: a maximum may not be symmetric."""
        if not any(
            _is_doubtful(point, doubt) for point in (*self.sweep.loaded, *self.sweep.no_load)
        ):
            return np.zeros(len(self.torque_nm))
        moved = [np.abs(self._moved_by(*way, doubt)) for way in ways]
        return np.asarray(np.max(moved, axis=0))

    def _moved_by(self, loaded: Pattern, no_load: Pattern, doubt: Doubt) -> Array:
        moved = replace(
            self.sweep,
            loaded=_all_shifted(self.sweep.loaded, loaded, doubt),
            no_load=_all_shifted(self.sweep.no_load, no_load, doubt),
        )
        return _torques(self.method(moved)) - self.torque_nm


def _all_shifted(
    points: Sequence[PeakPoint], pattern: Pattern, doubt: Doubt
) -> tuple[PeakPoint, ...]:
    return tuple(
        _shifted(point, pattern[i % len(pattern)], doubt) for i, point in enumerate(points)
    )


def _is_doubtful(point: PeakPoint, doubt: Doubt) -> bool:
    return isinstance(point, SwingPoint) and doubt(point) > 0


def _own_u_rad(point: SwingPoint) -> float:
    return point.phase_u_rad


def _common_u_rad(point: SwingPoint) -> float:
    return point.phase_common_u_rad


def _shifted(point: PeakPoint, sign: int, doubt: Doubt) -> PeakPoint:
    """Return the point with its torque shifted in crank phase by a standard uncertainty."""
    if not isinstance(point, SwingPoint) or not (shift := sign * doubt(point)):
        return point
    spectrum = np.fft.rfft(point.torque_nm, axis=-1)
    turn = np.exp(-1j * shift * np.arange(spectrum.shape[-1]))
    torque = np.fft.irfft(spectrum * turn, point.torque_nm.shape[-1], axis=-1)
    return replace(point, torque_nm=torque)


def _torques(compensation: Compensation) -> Array:
    return np.array([point.torque.value for point in compensation.points])


def _with_doubts(point: CompensatedPoint, effects_nm: dict[str, float]) -> CompensatedPoint:
    """Return the point with more in its model: of errors whose size is known, not their sign."""
    effects = [
        Effect(replace(limited(name, 1.0, "1"), common=name == COMMON), sqrt(3) * effect)
        for name, effect in effects_nm.items()
        if effect > 0
    ]
    return with_effects(point, effects)
