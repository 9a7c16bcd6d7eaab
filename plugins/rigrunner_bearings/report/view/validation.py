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
    found = torque.validation
    if found is None:
        return None
    trials = (found.equation.mean, *found.equation.points)
    draws = (found.pipeline.mean, *found.pipeline.points)
    return ValidationView(
        method=found.method,
        ways=WAYS,
        statements=found.statements,
        rows=tuple(_row(*each) for each in zip(trials, draws, strict=True)),
        notes=tuple(_notes(found)),
    )


def _row(by_trials: Agreement, by_draws: Agreement) -> ValidationRow:
    frequency = by_trials.set_frequency_hz
    both = (by_trials, by_draws)
    return ValidationRow(
        of="mean" if frequency is None else f"{plain(frequency)} Hz",
        u=tuple(
            significant(MILLI * u_nm, 2) for u_nm in (by_trials.gum.u, by_trials.u, by_draws.u)
        ),
        intervals=(
            _interval(by_trials.gum_low, by_trials.gum_high),
            *(_interval(each.low, each.high) for each in both),
        ),
        agree=tuple("yes" if each.agrees else "no" for each in both),
    )


def _interval(low_nm: float, high_nm: float) -> str:
    return f"{fixed(low_nm, 4)} to {fixed(high_nm, 4)}"


def _notes(found: Validation) -> Iterator[str]:
    pipeline = found.pipeline
    if pipeline.through_the_data:
        yield f"Drawn as errors of the recorded data: {'; '.join(pipeline.through_the_data)}."
    if pipeline.as_effects:
        yield f"Drawn as the effect that the budget states: {'; '.join(pipeline.as_effects)}."
    if pipeline.refused:
        yield f"The method refused {pipeline.refused} draws, which are not among them."
    if not found.equation.stable:
        yield "The trials had not settled to a fifth of the tolerance when they ended."
    yield f"Random numbers of seed {found.seed}: the same seed gives the same values."
