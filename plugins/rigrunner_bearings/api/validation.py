"""Validation of uncertainties of the GUM's law of propagation by a Monte Carlo method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Collection

    from numpy.random import Generator

    from rigrunner.api import Array, Estimate
    from rigrunner_bearings.api.compensations import Sweep


@dataclass(frozen=True)
class Agreement:
    """The 95 % intervals of one value by the GUM and by trials, in N·m."""

    set_frequency_hz: float | None
    """The set-point; None for the mean over all."""
    gum: Estimate
    gum_low: float
    gum_high: float
    mean: float
    u: float
    low: float
    high: float
    tolerance: float
    """Allowed difference of both ends, from the significant digits (JCGM 101:2008, 8.1.3)."""
    resolution: float
    """Uncertainty of each end from the limited number of trials."""
    agrees: bool

    @property
    def gum_is_wider(self) -> bool:
        """Whether the interval of the GUM contains that of the trials, within the tolerance."""
        low, high = self.gum_low - self.tolerance, self.gum_high + self.tolerance
        return low <= self.low and self.high <= high

    @property
    def apart(self) -> float:
        """The greater difference of the ends, d_low or d_high."""
        return max(abs(self.gum_low - self.low), abs(self.gum_high - self.high))


@dataclass(frozen=True)
class EquationTrials:
    """Trials of the measurement equation: JCGM 101:2008, 7.9 and 8."""

    mean: Agreement
    points: tuple[Agreement, ...]
    trials: int
    """The greatest number of trials of one value."""
    stable: bool
    """False if one value was not stable within the allowed number of trials."""


@dataclass(frozen=True)
class PipelineDraws:
    """Draws of the recorded data, each analysed again from the prepared cycles."""

    mean: Agreement
    points: tuple[Agreement, ...]
    draws: int
    refused: int
    """Draws that the method refused."""
    through_the_data: tuple[str, ...]
    """Lines of the budget that were drawn as errors of the data."""
    as_effects: tuple[str, ...]
    """Lines that were drawn as their stated effect on the torque."""


@dataclass(frozen=True)
class Validation:
    """Both validations of the result of the primary method."""

    method: str
    digits: int
    """Significant digits of the standard uncertainty."""
    seed: int
    equation: EquationTrials
    pipeline: PipelineDraws

    @property
    def agrees(self) -> bool:
        """Whether the interval of the mean agrees with both."""
        return self.equation.mean.agrees and self.pipeline.mean.agrees

    @property
    def statements(self) -> tuple[str, str]:
        """Statements on the mean: from the trials, and from the draws."""
        return _by_trials(self.equation), _by_draws(self.pipeline)


NARROW_SPACE = "\N{NARROW NO-BREAK SPACE}"


def _by_trials(equation: EquationTrials) -> str:
    mean, trials = equation.mean, f"{equation.trials:,} trials".replace(",", NARROW_SPACE)
    return (
        f"{_verdict(mean)} with {trials} of the measurement equation: {_ends(mean)}, "
        f"and {_milli(mean.tolerance)} is allowed (JCGM 101:2008, 8).{_advice(mean)}"
    )


def _by_draws(pipeline: PipelineDraws) -> str:
    mean = pipeline.mean
    return (
        f"{_verdict(mean)} with {pipeline.draws} draws of the recorded data, each analysed anew: "
        f"{_ends(mean)}, and {_milli(mean.tolerance)} is allowed, with up to "
        f"{_milli(mean.resolution)} more as draws are few.{_advice(mean)}"
    )


def _verdict(agreement: Agreement) -> str:
    return f"The GUM's interval {'agrees' if agreement.agrees else 'does not agree'}"


def _ends(agreement: Agreement) -> str:
    return f"the ends differ by up to {_milli(agreement.apart)}"


def _milli(torque_nm: float) -> str:
    return f"{1e3 * torque_nm:.2g} mN·m"


def _advice(agreement: Agreement) -> str:
    if agreement.agrees:
        return ""
    side = "wider: it is safe, and too wide" if agreement.gum_is_wider else "too narrow on a side"
    return (
        f" The GUM's is {side}. Use the Monte Carlo interval, {agreement.low:.4f} N·m to "
        f"{agreement.high:.4f} N·m."
    )


class Perturbation(Protocol):
    """Adds the errors of a rig, from the budget of a method, to a sweep."""

    @property
    def covers(self) -> Collection[str]:
        """Lines of the budget that it draws."""
        ...

    def __call__(self, sweep: Sweep, rng: Generator) -> Sweep:
        """Return the sweep with one draw of the errors."""
        ...


@runtime_checkable
class Drawable(Protocol):
    """An optional ability of a CompensationMethod, with which more lines can be drawn."""

    def torques(self, sweep: Sweep) -> Array:
        """Return the torque per point of the loaded run, shape (points,), without uncertainty.

        Raises DataError like the method.
        """
        ...

    def perturbation(self, sweep: Sweep) -> Perturbation:
        """Return the perturbation for this sweep; raise DataError."""
        ...
