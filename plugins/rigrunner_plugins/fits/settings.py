"""What the fits can be told; loads without numpy."""

from __future__ import annotations

from collections import Counter
from typing import Annotated, TypeVar

from pydantic import AfterValidator, Field

from rigrunner.api.settings import Length, ListOf, Settings, YesNo

Item = TypeVar("Item")


def _different(items: tuple[Item, ...]) -> tuple[Item, ...]:
    for item, times in Counter(items).items():
        if times > 1:
            raise ValueError(f"{item} stands {times} times; name it once")
    return items


def _ascending(powers: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(sorted(_different(powers)))


Power = Annotated[int, Field(ge=0, le=8)]
PowerSet = Annotated[ListOf[Power], Field(min_length=1), AfterValidator(_ascending)]


class WeightedSettings(Settings):
    """Of every least-squares fit."""

    weighted: Annotated[
        YesNo, Field(description="weigh each point by 1/u(y)²; the paper's fit does not")
    ] = False


class PolynomialSettings(WeightedSettings):
    """Of the fit `polynomial`."""

    degree: Annotated[int, Field(ge=1, le=8)] = 2
    """The highest power of x."""


class BasisSettings(WeightedSettings):
    """Of the fit `basis`."""

    powers: Annotated[
        PowerSet, Field(description="of the frequency; 0 is the intercept, such as [0, 2]")
    ]


class AiccSettings(WeightedSettings):
    """Of the fit `aicc`."""

    candidates: Annotated[
        ListOf[PowerSet],
        Field(min_length=1, description="sets of powers of the frequency; 0 is the intercept"),
        AfterValidator(_different),
    ] = ((0, 1, 2), (0, 2), (0, 1, 4), (0, 1, 2, 3))


class InertiaPhysicalSettings(WeightedSettings):
    """Of the fit `inertia_physical`: the drive's geometry, as the station has it."""

    eccentric: Annotated[Length, Field(gt=0)] = 0.002
    """How far the crank pin is from the crank's axis."""
    centre_distance: Annotated[Length, Field(gt=0)] = 0.045
    """Between the axes of crank and swing."""
