"""The no-load peak from the physics of the drive: support friction, damping, inertia.

Beyond a reversal the rig's own torque is T = J alpha(phi) + b omega(phi) + T0 with the swing's
acceleration alpha and velocity omega (of `rigrunner_bearings.signal.kinematics`), and
what the peak reading shows is its maximum over the forward stroke, omega >= 0:

    Tg(f) = T0 + max over phi of (J alpha(phi; f) + b omega(phi; f))

At low speed omega, which grows with f, decides; at high speed alpha, which grows with f^2; and the
phase of the peak moves from mid-stroke to the reversal in between. This is why a quadratic in f
leaves a pattern in its residuals. By the envelope theorem the derivatives of a maximum are those of
its argument at the phase where it is reached (1, omega, alpha): Gauss-Newton needs no more.

Neglected: presliding within a fraction of a degree of the reversal, and the drive line's resonance,
which friction's change of sign sets ringing. So the inertia is an apparent one, J': of a drive line
with its resonance at 600 Hz or above it is the true one within 8 %, at 300 Hz up to 30 % too large,
and its standard uncertainty, which comes from the scatter about the curve, does not show this. For
the inertia itself take a method that looks at the whole waveform.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner_bearings.signal.kinematics import (
    angular_acceleration,
    angular_velocity,
    max_acceleration,
    max_velocity,
    reversal_phase,
)
from rigrunner_plugins.fits.curve import FittedCurve, r_squared
from rigrunner_plugins.fits.least_squares import Solution, solve
from rigrunner_plugins.fits.points import (
    refuse_not_finite,
    refuse_other_units,
    refuse_several,
    root_weights,
)

if TYPE_CHECKING:
    from rigrunner.api import Array, Points
    from rigrunner_bearings.fits.settings import InertiaPhysicalSettings

PHASES = 1024
ITERATIONS = 50
STEP_TOLERANCE = 1e-9
_HINT = "peaks that show friction, damping and inertia apart rise with f, and later with f²"


@dataclass(frozen=True)
class InertiaPhysicalFit:
    """Gauss-Newton least squares of T0, b and J; satisfies `rigrunner.api.analysis.Fit`."""

    settings: InertiaPhysicalSettings

    def __call__(self, points: Points) -> FittedCurve:
        """Return the fitted curve; raise DataError where the points do not allow it."""
        refuse_several(points)
        refuse_other_units(points)
        refuse_not_finite(points)
        roots = root_weights(points, weighted=self.settings.weighted)
        parameters = self._start(points, roots)
        for _ in range(ITERATIONS):
            value, gradient = self._peak(points.x, parameters)
            solution = solve(gradient * roots[:, None], (points.y - value) * roots)
            step = solution.coefficients.astype(np.float64)
            parameters = parameters + step
            if np.all(np.abs(step) <= STEP_TOLERANCE * np.abs(parameters).max()):
                _refuse_unphysical(parameters)
                return self._curve(points, roots, parameters, solution)
        raise DataError("the physical fit does not converge", hint=_HINT)

    @property
    def _ratio(self) -> float:
        return self.settings.eccentric / self.settings.centre_distance

    def _start(self, points: Points, roots: Array) -> Array:
        """Return T0, b, J of the linear fit with omega and alpha at their own maxima."""
        omega = max_velocity(1.0, self._ratio) * points.x
        alpha = max_acceleration(1.0, self._ratio) * points.x**2
        design = np.column_stack([np.ones_like(omega), omega, alpha])
        start = solve(design * roots[:, None], points.y * roots).coefficients.astype(np.float64)
        # Without damping the peak is at the reversal, where omega is zero: no step would find it.
        return np.maximum(start, [0.0, 1e-3 * abs(start[0]), 0.0])

    def _peak(self, frequency_hz: Array, parameters: Array) -> tuple[Array, Array]:
        """Return the peak (n,) and its gradient (n, 3) for T0, b, J."""
        support, damping, inertia = parameters
        phase = self._peak_phase(frequency_hz, damping, inertia)
        omega = angular_velocity(phase, 1.0, self._ratio) * frequency_hz
        alpha = angular_acceleration(phase, 1.0, self._ratio) * frequency_hz**2
        gradient = np.column_stack([np.ones_like(omega), omega, alpha])
        return gradient @ np.array([support, damping, inertia]), gradient

    def _peak_phase(self, frequency_hz: Array, damping: float, inertia: float) -> Array:
        """Return the phase (n,) of the maximum: the best of a grid, refined by a parabola."""
        end = reversal_phase(self._ratio)
        grid = np.linspace(-end, end, PHASES)
        torque = damping * np.outer(frequency_hz, angular_velocity(grid, 1.0, self._ratio))
        torque += inertia * np.outer(frequency_hz**2, angular_acceleration(grid, 1.0, self._ratio))
        best = np.clip(torque.argmax(axis=1), 1, PHASES - 2)
        before, middle, after = (
            np.take_along_axis(torque, (best + k)[:, None], axis=1)[:, 0] for k in (-1, 0, 1)
        )
        bend = before - 2 * middle + after
        shift = np.divide(before - after, 2 * bend, out=np.zeros_like(bend), where=bend < 0)
        refined: Array = grid[best] + np.clip(shift, -1, 1) * (grid[1] - grid[0])
        return refined

    def _curve(
        self, points: Points, roots: Array, parameters: Array, solution: Solution
    ) -> FittedCurve:
        root = (solution.residual_s * solution.factor).astype(np.float64)
        residuals = points.y - self._peak(points.x, parameters)[0]

        def value_and_spread(x: Array) -> tuple[Array, Array]:
            value, gradient = self._peak(x, parameters)
            return value, gradient @ root

        return FittedCurve(
            formula="T = T0 + max over φ of [J'·dω/dt + b·ω](φ, f); J' includes the ringing",
            names=("T0", "b", "J'"),
            units=("N·m", "N·m·s/rad", "kg·m²"),
            coefficients=parameters,
            covariance=root @ root.T,
            dof=float(solution.dof),
            residuals=residuals,
            residual_s=solution.residual_s,
            r_squared=r_squared(points.y, residuals, roots=roots),
            valid_x=(float(points.x.min()), float(points.x.max())),
            root_weights=roots,
            value_and_spread=value_and_spread,
        )


def _refuse_unphysical(parameters: Array) -> None:
    """Neither damping nor inertia can be negative, and without damping the peak has no phase."""
    _, damping, inertia = parameters
    if damping <= 0 or inertia <= 0:
        raise DataError(
            f"the physical fit gives a damping of {damping:.3g} N·m·s/rad and an inertia of "
            f"{inertia:.3g} kg·m², which no rig has",
            hint=_HINT,
        )
