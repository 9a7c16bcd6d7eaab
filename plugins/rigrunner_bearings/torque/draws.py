"""Whole-pipeline draws: perturb the prepared data as the budget states, and analyse each again.

What of the budget is no error of the data, such as what a method neglects, is added to the torque
as the budget has it. So a draw has all errors once.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from math import copysign
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner.signal.monte_carlo.distributions import named
from rigrunner_bearings.api.validation import Drawable
from rigrunner_bearings.torque.resampling import another_sensor, other_cycles

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from numpy.random import Generator

    from rigrunner.api import Array
    from rigrunner_bearings.api.compensations import CompensatedPoint, CompensationMethod, Sweep
    from rigrunner_bearings.api.validation import Perturbation

BY_CYCLES = frozenset({"repeatability, loaded", "repeatability, no load", "scatter between cycles"})
BY_SENSOR = frozenset(
    {"sensor gain", "sensor non-linearity", "sensor offset", "sensor drift", "zero drift"}
)
STREAM = 1
"""Parts the draws' random numbers from those of the trials, which have the same seed."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """The torques of all draws, shape (draws, points), and how the budget went into them."""

    torque_nm: Array
    refused: int
    through_the_data: tuple[str, ...]
    as_effects: tuple[str, ...]


def draw_pipeline(
    method: CompensationMethod,
    sweep: Sweep,
    points: Sequence[CompensatedPoint],
    *,
    zeroed: bool,
    draws: int,
    seed: int,
    progress: Callable[[int, int], None],
) -> Drawn:
    """Analyse so many draws of the sweep; `points` are the method's, with their components.

    Raises DataError where the method refuses all of them.
    """
    maker = _maker(method, sweep, points, zeroed=zeroed)
    torques: list[Array] = []
    for number in range(draws):
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(STREAM, number)))
        with suppress(DataError):  # counted below
            torques.append(maker.draw(rng))
        progress(number + 1, draws)
    if not torques:
        raise DataError(f"the method refuses each of {draws} draws of its own data")
    lines = dict.fromkeys(part.name for point in points for part in point.components)
    return Drawn(
        torque_nm=np.array(torques),
        refused=draws - len(torques),
        through_the_data=tuple(name for name in lines if name in maker.covers),
        as_effects=tuple(name for name in lines if name not in maker.covers),
    )


@dataclass(frozen=True, eq=False)
class _Maker:
    torques: Callable[[Sweep], Array]
    sweep: Sweep
    points: Sequence[CompensatedPoint]
    rig_errors: Perturbation
    covers: Collection[str]
    zeroed: bool

    def draw(self, rng: Generator) -> Array:
        """Return the torques of one draw, shape (points,)."""
        changed = self.rig_errors(self.sweep, rng)
        changed = another_sensor(changed, rng, zeroed=self.zeroed)
        return self.torques(other_cycles(changed, rng)) + self._effects(rng)

    def _effects(self, rng: Generator) -> Array:
        """Return the effects of lines that are no errors of the data, common ones drawn once."""
        shared: dict[str, float] = {}
        effects = np.zeros(len(self.points))
        for place, point in enumerate(self.points):
            for part in point.components:
                if part.name in self.covers or part.u == 0:
                    continue
                fresh = float(named(part.distribution, 0.0, 1.0, part.dof).draw(rng, 1)[0])
                error = shared.setdefault(part.name, fresh) if part.common else fresh
                # A common error moves two points against each other where their sensitivities
                # have two signs.
                effects[place] += error * copysign(part.u, part.sensitivity)
        return effects


def _maker(
    method: CompensationMethod, sweep: Sweep, points: Sequence[CompensatedPoint], *, zeroed: bool
) -> _Maker:
    generic = BY_CYCLES | BY_SENSOR
    if isinstance(method, Drawable):
        rig_errors = method.perturbation(sweep)
        covers = generic | frozenset(rig_errors.covers)
        return _Maker(method.torques, sweep, points, rig_errors, covers, zeroed)

    def torques(changed: Sweep) -> Array:
        return np.array([point.torque.value for point in method(changed).points])

    return _Maker(torques, sweep, points, _NoRigErrors(), generic, zeroed)


class _NoRigErrors:
    """Of a method that states no errors of the rig as data."""

    covers: Collection[str] = ()

    def __call__(self, sweep: Sweep, rng: Generator) -> Sweep:  # noqa: ARG002  (as all)
        """Return the sweep as it is."""
        return sweep
