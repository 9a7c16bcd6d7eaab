"""Combining standard uncertainties with their degrees of freedom (JCGM 100, the GUM)."""

from __future__ import annotations

from math import inf, isinf, sqrt
from typing import TYPE_CHECKING

import scipy

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api.analysis import Component


def combine(components: Iterable[Component]) -> tuple[float, float]:
    """Return the standard uncertainty of independent components and its degrees of freedom.

    Root sum of squares (GUM 5.1.2) and the Welch-Satterthwaite formula (GUM G.4.1); the degrees
    of freedom are infinite if nothing limits them.
    """
    pairs = [(part.u, part.dof) for part in components if part.u > 0]
    u = sqrt(sum(u**2 for u, _ in pairs))
    spread = sum((part / u) ** 4 / dof for part, dof in pairs)
    return u, 1 / spread if spread > 0 else inf


def share_percent(components: Sequence[Component]) -> tuple[float, ...]:
    """Return what each component makes up of the variance, in per cent; nan where one is unknown.

    Of no variance at all each makes up nothing.
    """
    total = sum(part.u**2 for part in components)
    return tuple(100 * part.u**2 / total if total != 0 else 0.0 for part in components)


def coverage_factor(dof: float, p: float = 0.95) -> float:
    """Return the factor k of a two-sided interval of probability p (Student's t, GUM G.3.4)."""
    if isinf(dof):
        return float(scipy.special.ndtri((1 + p) / 2))
    return float(scipy.special.stdtrit(dof, (1 + p) / 2))
