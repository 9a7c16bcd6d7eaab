"""Settings of the fits; loads without numpy."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from math import isfinite
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
)

from rigrunner.api import ListOf, PlainText, Settings, YesNo, unit
from rigrunner.api.units import is_coherent, si_symbol
from rigrunner.signal.expression.syntax import Expression, parse

Item = TypeVar("Item")


def _different(items: tuple[Item, ...]) -> tuple[Item, ...]:
    for item, times in Counter(items).items():
        if times > 1:
            raise ValueError(f"{item} is listed {times} times; list it once")
    return items


Power = Annotated[int, Field(ge=0, le=8)]
PowerSet = Annotated[
    ListOf[Power],
    Field(min_length=1),
    AfterValidator(lambda powers: tuple(sorted(_different(powers)))),
]


class WeightedSettings(Settings):
    """Of every least-squares fit."""

    weighted: Annotated[
        YesNo, Field(description="weigh each point by 1/u(y)²; the paper's fit does not")
    ] = False


class PolynomialSettings(WeightedSettings):
    """Settings of the fit `polynomial`."""

    degree: Annotated[int, Field(ge=1, le=10)] = 2
    """Highest power of x."""


class BasisSettings(WeightedSettings):
    """Settings of the fit `basis`."""

    powers: Annotated[
        PowerSet, Field(description="powers of x, such as [0, 2]; 0 is the intercept")
    ]


class AiccSettings(WeightedSettings):
    """Settings of the fit `aicc`."""

    candidates: Annotated[
        ListOf[PowerSet],
        Field(min_length=1, description="sets of powers of x; 0 is the intercept"),
        AfterValidator(_different),
    ] = ((0, 1, 2), (0, 2), (0, 1, 4), (0, 1, 2, 3))


class Start(NamedTuple):
    """Where the search for a parameter begins."""

    value: float
    """In the SI unit."""
    unit: str
    """The SI unit of what was written; 1 where none was."""


_START = r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(?:\s+(\S{1,20}))?\s*"


def _start(value: object) -> object:
    if isinstance(value, Start):
        return value
    match = re.fullmatch(_START, "" if isinstance(value, bool) else str(value)[:60], re.ASCII)
    if match is None or not isfinite(float(match[1])):
        raise ValueError(
            f"{str(value)[:40]!r} is not a number, nor a number with its unit such as '0.9 N·m'"
        )
    written = unit(match[2] or "1")
    if written.offset:
        raise ValueError(f"'{value}' does not have the zero of K: write it in K")
    if is_coherent(written):
        return Start(float(match[1]), match[2] or "1")
    return Start(float(match[1]) * written.factor, si_symbol(written.dimension))


StartValue = Annotated[
    Start,
    BeforeValidator(_start),
    WithJsonSchema(
        {
            "anyOf": [{"type": "number"}, {"type": "string"}],
            "description": "a number, with the parameter's unit where it has one",
        }
    ),
]


class ExpressionSettings(WeightedSettings):
    """Settings of the fit `expression`."""

    over: Annotated[
        ListOf[PlainText],
        Field(min_length=1, description="names of the variables in the model"),
        AfterValidator(_different),
    ] = ("f",)
    start: Annotated[
        Mapping[str, StartValue],
        Field(min_length=1, description="the parameters, each with its start value"),
    ]
    model: Annotated[
        str,
        Field(
            min_length=1, description="a formula such as T0 + b*f + J*f**2; see the page on fits"
        ),
    ]

    @field_validator("model")
    @classmethod
    def _is_a_formula(cls, model: str, info: ValidationInfo) -> str:
        fields: dict[str, Any] = info.data
        if {"over", "start"} <= fields.keys():
            parameters, variables = set(fields["start"]), set(fields["over"])
            if parameters & variables:
                raise ValueError(f"{_quoted(parameters & variables)}: a variable and a parameter")
            unused = (parameters | variables) - parse(model, parameters | variables).names()
            if unused:
                raise ValueError(f"it does not have {_quoted(unused)}")
        return model

    @property
    def expression(self) -> Expression:
        """The model that was read."""
        return parse(self.model, {*self.start, *self.over})


def _quoted(names: set[str]) -> str:
    return ", ".join(f"'{name[:20]}'" for name in sorted(names))
