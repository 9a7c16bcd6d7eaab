"""The rules for gross errors."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice, takewhile
from math import pi, sqrt
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from scipy.special import ndtri, stdtrit

from rigrunner.api import DataError, Rejection
from rigrunner_plugins.outlier_rules.requirements import BLIND_OF_PAUTA

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api import Array
    from rigrunner_plugins.outlier_rules.settings import (
        GeneralizedEsdSettings,
        GrubbsSettings,
        MadSettings,
    )

LEAST = 3
"""Of two values none is the odd one."""

ROUNDING = 1e-14
"""Relative, some forty times that of a number: where no more than this scatters, none is odd."""
LEAST_PER_ERROR = 5
"""In a small sample `GeneralizedEsd` rejects good values more often than alpha says, the more the
more errors it looks for; so it looks for one among five values at most."""
SIGMA_PER_MAD: Final = 1 / float(ndtri(0.75))
"""Of the normal distribution: half of it lies within 0.6745 standard deviations."""
SIGMA_PER_MEAN_DEVIATION: Final = sqrt(pi / 2)
"""Of the normal distribution, whose mean absolute deviation is sqrt(2/pi) sigma."""


@dataclass(frozen=True)
class Grubbs:
    """Grubbs' test for one gross error in normal values, repeated until it finds none.

    Grubbs, Technometrics 11(1), 1969; ISO 5725-2, 7.3.4. Several gross errors of like size hide
    each other from it; `GeneralizedEsd` finds them. Satisfies `rigrunner.api.analysis.OutlierRule`.
    """

    settings: GrubbsSettings

    def __call__(self, values: Array) -> list[Rejection]:
        """Return the rejections in values of shape (n,), in the order in which they were made."""
        return list(takewhile(exceeds, suspects("grubbs", values, self._suspect)))

    def _suspect(self, sample: Array) -> Suspect | None:
        n = len(sample)
        if n < LEAST:
            return None
        deviation = studentized(sample)
        distance = {"both": np.abs(deviation), "high": deviation, "low": -deviation}[
            self.settings.side
        ]
        worst = int(distance.argmax())
        two_sided = self.settings.side == "both"
        critical = critical_value(n, self.settings.alpha, two_sided=two_sided)
        return Suspect(worst, float(distance[worst]), critical)


@dataclass(frozen=True)
class GeneralizedEsd:
    """Rosner's generalized extreme studentized deviate test: several errors, also such as mask.

    Rosner, Technometrics 25(2), 1983; NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.5.17.3.
    The most extreme value is taken out again and again, up to a number chosen beforehand, and only
    then is the last one looked for that exceeds its critical value: it is rejected with all before
    it. Two like errors inflate the standard deviation, so that the first does not exceed; the
    repeated Grubbs' test stops there. The critical value of the i-th is that of Grubbs for the
    n - i + 1 values then left. Two-sided; satisfies `rigrunner.api.analysis.OutlierRule`.
    """

    settings: GeneralizedEsdSettings

    def __call__(self, values: Array) -> list[Rejection]:
        """Return the rejections in values of shape (n,), the most extreme first.

        A masked one carries its own statistic, which need not exceed its critical value; that of
        the last one does.
        """
        at_most = max(1, min(self.settings.at_most, len(values) // LEAST_PER_ERROR))
        rejections = list(islice(suspects("generalized_esd", values, self._suspect), at_most))
        exceeding = [count for count, rejection in enumerate(rejections, 1) if exceeds(rejection)]
        return rejections[: max(exceeding, default=0)]

    def _suspect(self, sample: Array) -> Suspect | None:
        n = len(sample)
        if n < LEAST:
            return None
        distance = np.abs(studentized(sample))
        worst = int(distance.argmax())
        return Suspect(worst, float(distance[worst]), critical_value(n, self.settings.alpha))


def pauta(values: Array) -> list[Rejection]:
    """Return the rejections in values of shape (n,), worst first; DataError for n <= 10.

    The 3-sigma rule, named after Pauta or Wright, repeated until it finds none. It takes the
    sample's own standard deviation for sigma. In n values no deviation can be more than
    (n - 1)/sqrt(n) of these (Shiffler, The American Statistician 42(1), 1988), which is below 3 up
    to n = 10: there the rule can reject nothing, whatever the values, and is refused.
    """
    n = len(values)
    if n <= BLIND_OF_PAUTA:
        reach = f": no deviation can exceed (n - 1)/√n = {(n - 1) / sqrt(n):.2f}" if n > 1 else ""
        raise DataError(
            f"pauta, the 3-sigma rule, can reject none of {n} values{reach}",
            hint=f"record more than {BLIND_OF_PAUTA} cycles, or use grubbs",
        )

    def suspect(sample: Array) -> Suspect:
        distance = np.abs(studentized(sample))
        worst = int(distance.argmax())
        return Suspect(worst, float(distance[worst]), 3.0)

    return list(takewhile(exceeds, suspects("pauta", values, suspect)))


def chauvenet(values: Array) -> list[Rejection]:
    """Return the rejections in values of shape (n,), in their order; of n < 3 there are none.

    Chauvenet's criterion, applied once. Taylor, An Introduction to Error Analysis, chapter 6: a
    value is rejected if fewer than half a value of n is expected to lie as far from the mean. So of
    normal values, too, about one sample in three loses one; repeated, the rule would go on eating
    them.
    """
    n = len(values)
    if n < LEAST:
        return []
    distance, critical = np.abs(studentized(values)), chauvenet_critical_value(n)
    return [
        Rejection(int(index), float(values[index]), "chauvenet", float(distance[index]), critical)
        for index in np.flatnonzero(distance > critical)
    ]


@dataclass(frozen=True)
class Mad:
    """The modified z-score, once: distance from the median in median absolute deviations.

    Iglewicz and Hoaglin, How to Detect and Handle Outliers, 1993; NIST/SEMATECH e-Handbook of
    Statistical Methods, 1.3.5.17. Median and MAD are not moved by the gross errors themselves, up
    to half of the values. The threshold 3.5 is theirs, a recommendation and no risk: of few normal
    values it rejects one more often than of many. Satisfies `rigrunner.api.analysis.OutlierRule`.
    """

    settings: MadSettings

    def __call__(self, values: Array) -> list[Rejection]:
        """Return the rejections in values of shape (n,), in their order."""
        if len(values) < LEAST:
            return []
        score, critical = modified_z_score(values), self.settings.threshold
        return [
            Rejection(int(index), float(values[index]), "mad", float(score[index]), critical)
            for index in np.flatnonzero(score > critical)
        ]


def modified_z_score(values: Array) -> Array:
    """Return the distances (n,) from the median in robust standard deviations.

    Where more than half of the values are one and the same, their MAD is zero and their mean
    absolute deviation takes its place; zeros where that, too, is rounding.
    """
    distance = np.abs(values - np.median(values))
    rounding = ROUNDING * np.abs(values).max()
    sigma = SIGMA_PER_MAD * float(np.median(distance))
    if sigma <= rounding:
        sigma = SIGMA_PER_MEAN_DEVIATION * float(distance.mean())
    if sigma <= rounding:
        return np.zeros_like(distance)
    score: Array = distance / sigma
    return score


def keep_all(values: Array) -> list[Rejection]:  # noqa: ARG001  (the contract gives the values)
    """Reject nothing."""
    return []


def chauvenet_critical_value(n: int) -> float:
    """Return the deviation, in standard deviations, that half a value of n is expected beyond."""
    return -float(ndtri(1 / (4 * n)))


class Suspect(NamedTuple):
    """The position in a sample of its most extreme value, with the numbers that judge it."""

    position: int
    statistic: float
    critical: float


def suspects(
    rule: str, values: Array, judge: Callable[[Array], Suspect | None]
) -> Iterator[Rejection]:
    """Yield the suspect of values of shape (n,), then that of those left, until there is none."""
    remaining = np.arange(len(values))
    while (suspect := judge(values[remaining])) is not None:
        index = int(remaining[suspect.position])
        yield Rejection(index, float(values[index]), rule, suspect.statistic, suspect.critical)
        remaining = np.delete(remaining, suspect.position)


def exceeds(rejection: Rejection) -> bool:
    """Return whether a suspect's statistic is beyond its critical value."""
    return rejection.statistic > rejection.critical


def studentized(sample: Array) -> Array:
    """Return (x - mean)/s of a sample of shape (n,), n >= 2; zeros where only rounding scatters."""
    s = sample.std(ddof=1)
    if s <= ROUNDING * np.abs(sample).max():
        return np.zeros_like(sample)
    deviation: Array = (sample - sample.mean()) / s
    return deviation


def critical_value(n: int, alpha: float, *, two_sided: bool = True) -> float:
    """Return what the largest studentized deviate of n >= 3 normal values exceeds with risk alpha.

    Grubbs, Technometrics 11(1), 1969. With t the quantile of Student's t with n - 2 degrees of
    freedom that alpha/n (two-sided: alpha/2n) exceeds: (n - 1)/sqrt(n) * sqrt(t^2/(n - 2 + t^2)).
    """
    tail = alpha / (2 * n if two_sided else n)
    t = -float(stdtrit(n - 2, tail))
    return (n - 1) / sqrt(n) / sqrt(1 + (n - 2) / t / t)
