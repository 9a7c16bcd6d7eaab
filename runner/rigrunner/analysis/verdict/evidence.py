"""What there is to decide on, and what forbids to decide on it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Consequence
from rigrunner.api.checks import effect_words

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigrunner.api.analysis import Check, Compensation, PeakPoint
    from rigrunner.api.findings import MeasurementResult
    from rigrunner.api.measurand import MeasurandKind

LEAST_FOR_SCATTER = 2


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """All results of a run that limits may be for."""

    results: tuple[MeasurementResult, ...] = ()
    means: tuple[MeasurementResult, ...] = ()
    """Of those results whose analysis gives their mean itself."""
    problems: Mapping[str, str] = field(default_factory=dict)
    """Why nothing can be decided on the results of a name, as a sentence; '' where it can."""
    torque: str = ""
    """The name of the compensated torque; '' where there is none."""
    method: str = ""
    """Its compensation, by its label."""
    kind: MeasurandKind | None = None
    """Which torque it yields; None where its plugin does not say."""
    loads_n: tuple[float, ...] = ()
    """Of each of its set-points."""


def forbidden(checks: Iterable[Check]) -> str:
    """Return the first check that forbids to decide, as a sentence; '' where none does."""
    for check in checks:
        if check.consequence is Consequence.INCONCLUSIVE:
            advice = f" ({check.advice})" if check.advice else ""
            effect = f"; {words}" if (words := effect_words(check)) else ""
            return f"The check '{check.name}' failed: {check.text}{effect}{advice}."
    return ""


def as_judged(check: Check) -> Check:
    """Return a check of named results: one that is decisive forbids to decide, others are notes."""
    if check.ok:
        return check
    fails = check.decisive
    follows = Consequence.INCONCLUSIVE if fails else Consequence.NOTE
    return replace(check, ok=not fails, consequence=follows)


def without_scatter(
    loaded: Sequence[PeakPoint], no_load: Sequence[PeakPoint], compensation: Compensation
) -> str:
    """Return which single values leave type A unknown, as a sentence; '' where none do.

    A no-load value that goes into a fitted curve has its scatter about that curve.
    """
    used = loaded if compensation.curve is not None else (*loaded, *no_load)
    names = dict.fromkeys(
        f"{point.set_frequency_hz:g} Hz"
        for point in used
        if point.peak_kept.sum() < LEAST_FOR_SCATTER
    )
    if not names:
        return ""
    return (
        f"A single value shows no scatter (at {', '.join(names)}): the uncertainty lacks its "
        "type A part, and no probability can be stated."
    )
