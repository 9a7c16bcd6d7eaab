"""Whether Monte Carlo agrees with the stated uncertainty: a sentence each, and a small table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_reports.numbers import fixed, plain, significant

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner_bearings.api.torque import TorqueDetails
    from rigrunner_bearings.api.validation import Agreement, Validation

MILLI = 1e3
WAYS = ("GUM", "trials", "draws")


@dataclass(frozen=True)
class ValidationRow:
    """One value by the GUM, by trials and by draws: u in mN·m, intervals of 95 % in N·m."""

    of: str
    u: tuple[str, ...]
    intervals: tuple[str, ...]
    agree: tuple[str, ...]
    """Of trials and of draws."""


@dataclass(frozen=True)
class ValidationView:
    """The section on validation."""

    method: str
    ways: tuple[str, ...]
    statements: tuple[str, ...]
    rows: tuple[ValidationRow, ...]
    notes: tuple[str, ...]


def validation(torque: TorqueDetails) -> ValidationView | None:
    """Return the section, or None where the procedure asks for no validation."""
    result = torque.validation
    if result is None:
        return None
    trials = (result.equation.mean, *result.equation.points)
    draws = (result.pipeline.mean, *result.pipeline.points)
    return ValidationView(
        method=result.method,
        ways=WAYS,
        statements=result.statements,
        rows=tuple(_row(*agreements) for agreements in zip(trials, draws, strict=True)),
        notes=tuple(_notes(result)),
    )


def _row(by_trials: Agreement, by_draws: Agreement) -> ValidationRow:
    frequency = by_trials.set_frequency_hz
    agreements = (by_trials, by_draws)
    return ValidationRow(
        of="mean" if frequency is None else f"{plain(frequency)} Hz",
        u=tuple(
            significant(MILLI * u_nm, 2) for u_nm in (by_trials.gum.u, by_trials.u, by_draws.u)
        ),
        intervals=(
            _interval(by_trials.gum_low, by_trials.gum_high),
            *(_interval(agreement.low, agreement.high) for agreement in agreements),
        ),
        agree=tuple("yes" if agreement.agrees else "no" for agreement in agreements),
    )


def _interval(low_nm: float, high_nm: float) -> str:
    return f"{fixed(low_nm, 4)} to {fixed(high_nm, 4)}"


def _notes(result: Validation) -> Iterator[str]:
    pipeline = result.pipeline
    if pipeline.through_the_data:
        yield f"Drawn as errors of the recorded data: {'; '.join(pipeline.through_the_data)}."
    if pipeline.as_effects:
        yield f"Drawn as the effect that the budget states: {'; '.join(pipeline.as_effects)}."
    if pipeline.refused:
        yield f"The method refused {pipeline.refused} draws, which are not among them."
    if not result.equation.stable:
        yield "The trials had not settled to a fifth of the tolerance when they ended."
    yield f"Random numbers of seed {result.seed}: the same seed gives the same values."
