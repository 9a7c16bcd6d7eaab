"""The fits of the no-load peaks, with their coefficients."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import Chosen
from rigrunner_reports.numbers import fixed, plain, significant, with_standard_uncertainty

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Curve
    from rigrunner_bearings.api.torque import FittedTorque

MILLI = 1e3


@dataclass(frozen=True)
class CandidateView:
    """One of the curves that a fit chose from; `problem` says why it could not be fitted."""

    formula: str
    residual_s: str
    score: str
    chosen: bool
    problem: str


@dataclass(frozen=True)
class FitView:
    """One fit; `problem` says why there is no curve."""

    name: str
    problem: str = ""
    formula: str = ""
    coefficients: tuple[tuple[str, str], ...] = ()
    residual_s: str = ""
    dof: str = ""
    r_squared: str = ""
    range: str = ""
    criterion: str = ""
    candidates: tuple[CandidateView, ...] = ()


def fit_views(fits: Sequence[FittedTorque]) -> tuple[FitView, ...]:
    """Return the fits, ready to print."""
    return tuple(
        FitView(fit.name, fit.problem or "it gave no curve")
        if fit.curve is None
        else _view(fit.name, fit.curve)
        for fit in fits
    )


def _view(name: str, curve: Curve) -> FitView:
    u = np.sqrt(np.diag(curve.covariance))
    low, high = curve.valid_x
    return FitView(
        name=name,
        formula=curve.formula,
        coefficients=tuple(
            (label, with_standard_uncertainty(float(value), float(spread), unit))
            for label, value, spread, unit in zip(
                curve.names, curve.coefficients, u, curve.units, strict=True
            )
        ),
        residual_s=significant(MILLI * curve.residual_s, 3),
        dof=plain(curve.dof),
        r_squared=fixed(curve.r_squared, 6),
        range=f"{low:.4g} Hz to {high:.4g} Hz",
        criterion=curve.criterion if isinstance(curve, Chosen) else "",
        candidates=tuple(
            CandidateView(
                formula=candidate.formula,
                residual_s=significant(MILLI * candidate.residual_s, 3),
                score=fixed(candidate.score, 1),
                chosen=candidate.chosen,
                problem=candidate.problem,
            )
            for candidate in (curve.candidates if isinstance(curve, Chosen) else ())
        ),
    )


RIG = "No-load torque"
"""The title of the section."""
