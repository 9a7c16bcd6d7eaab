"""What a procedure says of the analysis `readings`. Loads without numpy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    TypeAdapter,
    WithJsonSchema,
    model_validator,
)

from rigrunner.api import (
    ListOf,
    NeededChannel,
    PartnerRun,
    PlainText,
    QuantityError,
    Ratio,
    Requirements,
    ResultDefinition,
    Settings,
    unit,
)
from rigrunner.api.member import NAME
from rigrunner.api.partners import PartnerName  # noqa: TC001  (pydantic reads it)
from rigrunner.api.places import CoordinateKey, Place
from rigrunner.api.settings import Difference
from rigrunner.api.units import is_coherent, with_article

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api import NeededRun, Objection

Statistic = Literal[
    "mean",
    "minimum",
    "maximum",
    "range",
    "rms",
    "standard_deviation",
    "percentile",
    "slope",
    "settling_time",
]
_KEY = TypeAdapter(CoordinateKey).json_schema()
_VALUE = rf"^{NAME}\.{NAME}(\.(mean|minimum|maximum|peak_to_peak|rms))?$"
ValueName = Annotated[str, Field(pattern=_VALUE)]
"""A channel, 'role.name', or a statistic of its samples, 'role.name.rms'."""


def _one_or_several(value: object) -> object:
    return [value] if isinstance(value, str) else value


Per = Annotated[
    ListOf[CoordinateKey],
    BeforeValidator(_one_or_several),
    WithJsonSchema({"anyOf": [_KEY, {"type": "array", "items": _KEY}]}),
]
"""One coordinate, or several, by which results are told apart."""


def _symbol(text: str) -> str:
    return unit(text).symbol


class ResultSettings(Settings):
    """What the result is called, and in which unit it is stated."""

    name: Annotated[str, Field(pattern=f"^{NAME}$")]
    """By which limits, report and certificate name it."""
    symbol: PlainText = ""
    """Such as R."""
    text: PlainText = ""
    """The measurand in words, such as 'load regulation'."""
    unit: Annotated[str, AfterValidator(_symbol)]
    """Such as mV."""
    id: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")] | None = None
    """The measurand for programs, by a list that they share, such as voltage.dc.regulation."""

    def definition(self, per: tuple[str, ...]) -> ResultDefinition:
        """Return what an analysis yields by it, a result for each value of some coordinates."""
        return ResultDefinition(
            name=self.name,
            symbol=self.symbol,
            text=self.text,
            unit=self.unit,
            per=per,
            id=self.id or "",
        )


class ComparedRun(PartnerRun):
    """The run whose value is taken off, or divided by."""

    name: PartnerName
    """By which `--partner` and documents name it."""
    per: Per = ()
    """Its value at each of these coordinates of the analysis' own `per`; left out, one value of
    all of it."""
    where: Place = Field(default_factory=dict)
    """Only of what was measured there in it."""


class TareRun(ComparedRun):
    """A run whose value is taken off: of a dark detector, an empty balance."""

    name: PartnerName = "tare"


class ReferenceRun(ComparedRun):
    """A run by whose value is divided: of a reference specimen."""

    name: PartnerName = "reference"


class ReadingsSettings(Settings):
    """A statistic of a recorded channel, or of a column of measured values."""

    of: ValueName
    """The channel, such as meter.voltage; or a statistic that `record` keeps of one, such as
    tester.torque.rms."""
    statistic: Statistic = "mean"
    """What is taken of its values: over each group of `per`, or over all."""
    minus: ValueName | None = None
    """A channel that was read with it: the statistic is of the differences, value by value."""
    divided_by: ValueName | None = None
    """A channel that was read with it: the statistic is of the quotients, value by value."""
    per: Per = ()
    """A result for each value of these set-points or coordinates, such as [load.current]."""
    where: Place = Field(default_factory=dict)
    """Only of what was measured there, such as {load.current: 2 A}."""
    table: Annotated[str, Field(pattern=f"^{NAME}$")] | None = None
    """Only of the rows of this table; left out, of the recordings, or else of all tables."""
    percent: Annotated[Ratio, Field(gt=0, lt=1)] | None = None
    """Of `percentile`: how many of the values are at most as great, such as 95 %."""
    within: Difference | None = None
    """Of `settling_time`: how far from the last value counts as settled."""
    tare: TareRun | None = None
    """Another run whose same statistic is taken off this one's, such as a dark reading."""
    relative_to: ReferenceRun | None = None
    """Another run by whose same statistic this one's is divided, such as a reference specimen."""
    result: ResultSettings

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.tare is not None and self.relative_to is not None:
            raise ValueError("one of 'tare' and 'relative_to' is allowed, not both")
        if self.compared is not None and not set(self.compared.per) <= set(self.per):
            raise ValueError("a partner run's 'per' names coordinates of the analysis' own 'per'")
        if self.minus is not None and self.divided_by is not None:
            raise ValueError("one of 'minus' and 'divided_by' is allowed, not both")
        for key, statistic in (("percent", "percentile"), ("within", "settling_time")):
            given = getattr(self, key) is not None
            if given and self.statistic != statistic:
                raise ValueError(f"'{key}' belongs to the statistic {statistic}")
            if not given and self.statistic == statistic:
                raise ValueError(f"the statistic {statistic} needs the key '{key}'")
        return self

    @property
    def other(self) -> str | None:
        """The channel that is subtracted or divided by."""
        return self.minus or self.divided_by

    @property
    def is_difference(self) -> bool:
        """Whether the result is a difference of values: of temperatures in K, from no zero."""
        return bool(self.minus or self.compared) or self.statistic in {
            *DIFFERENCES, "slope", "settling_time",
        }  # fmt: skip

    @property
    def compared(self) -> ComparedRun | None:
        """The partner run whose value is taken off or divided by."""
        return self.tare or self.relative_to

    def yields(self) -> tuple[ResultDefinition, ...]:
        """Return the one result."""
        return (self.result.definition(self.per),)

    def requires(self) -> Requirements:
        """Return the channels that it reads."""
        named = (("of", self.of), ("minus", self.minus), ("divided_by", self.divided_by))
        channels = tuple(
            NeededChannel(name=name, key=(key,), enters=(self.result.name,))
            for key, name in named
            if name is not None
        )
        partners: tuple[NeededRun, ...] = ()
        if self.compared is not None:
            key = ("tare",) if self.tare else ("relative_to",)
            needed = self.compared.needed(
                self.compared.name, key, channels=channels, at=tuple(self.compared.per)
            )
            partners = (needed,)
        return Requirements(channels=channels, partners=partners)

    def objections(self, units: Mapping[str, str]) -> Iterator[Objection]:
        """Yield what does not fit the units in which the channels are measured."""
        of = unit(units[self.of])
        if self.minus is not None and unit(units[self.minus]).dimension != of.dimension:
            other = unit(units[self.minus])
            yield (
                ("minus",),
                (
                    f"{self.minus} is {with_article(other.dimension)}, and {self.of}"
                    f" {with_article(of.dimension)}"
                ),
                "subtract what is of one kind",
            )
            return
        value = units[self.of]
        if self.divided_by is not None:
            try:
                value = quotient(value, units[self.divided_by])
            except QuantityError as error:
                yield ("divided_by",), error.message, error.hint
                return
        if self.within is not None and self.within.dimension != unit(value).dimension:
            wanted = unit(value).dimension
            message = (
                f"got '{self.within}', {with_article(self.within.dimension)}; expected"
                f" {with_article(wanted)}"
            )
            yield ("within",), message, ""
        try:
            si = si_unit(self.statistic, value)
        except QuantityError as error:
            yield ("statistic",), error.message, error.hint
            return
        si = "1" if self.relative_to else si
        result = unit(self.result.unit)
        if result.dimension != unit(si).dimension:
            is_a = f"the {self.statistic} is {with_article(unit(si).dimension)}"
            if self.relative_to is not None:
                is_a = f"a quotient of two runs is {with_article(unit(si).dimension)}"
            message = f"got '{self.result.unit}', {with_article(result.dimension)}; {is_a}"
            hint = f"write a unit such as {unit(si).symbol}"
            if self.statistic == "slope":
                hint += "; a slope over a channel or set-point is a result of the analysis 'curve'"
            yield ("result", "unit"), message, hint
        elif result.offset and self.statistic in DIFFERENCES | (
            {self.statistic} if self.minus or self.tare else set()
        ):
            yield (
                ("result", "unit"),
                f"got '{self.result.unit}', and the result is a difference of temperatures",
                "write K",
            )


DIFFERENCES = {"range", "standard_deviation"}
"""The statistics that are differences of values: of temperatures they are in K."""


def quotient(above: str, below: str) -> str:
    """Return the SI unit of the quotient of two SI units; raise QuantityError for none."""
    if unit(above).dimension == unit(below).dimension:
        return "1"
    if below == "1":
        return above
    composed = f"({below})" if {"·", "/"} & set(below) else below
    if "/" in above or "/" in below:  # m/s over s: one quotient of products
        over, _, under = above.partition("/")
        below_over, _, below_under = below.partition("/")
        numerator = "·".join(each for each in (over.strip("()"), below_under.strip("()")) if each)
        denominator = "·".join(each for each in (under.strip("()"), below_over.strip("()")) if each)
        return unit(f"{numerator}/({denominator})" if "·" in denominator
                    else f"{numerator}/{denominator}").symbol  # fmt: skip
    return unit(f"{above}/{composed}").symbol


def si_unit(statistic: str, value: str) -> str:
    """Return the SI unit of a statistic of values in an SI unit."""
    if statistic == "settling_time":
        return "s"
    if statistic == "slope":
        return quotient(value, "s")
    assert is_coherent(unit(value)), value  # noqa: S101  (values are in SI units)
    return value
