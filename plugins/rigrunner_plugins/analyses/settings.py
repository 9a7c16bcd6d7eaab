"""Settings of the analysis `readings`. Does not import numpy."""

from __future__ import annotations

import re
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
    UnitSymbol,
    unit,
)
from rigrunner.api.member import NAME
from rigrunner.api.partners import PartnerName  # noqa: TC001  (pydantic reads it)
from rigrunner.api.places import CoordinateKey, Place
from rigrunner.api.settings import Difference
from rigrunner.api.unit_tables import LEVELS
from rigrunner.api.units import (
    exponents_of,
    is_coherent,
    kind_of,
    of_difference,
    si_symbol,
    with_article,
)

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
    "integral",
    "settling_time",
]
_POINTS_ON_A_SCALE = {"temperature", *LEVELS}
_KEY = TypeAdapter(CoordinateKey).json_schema()
_VALUE = rf"{NAME}\.{NAME}(\.(mean|minimum|maximum|peak_to_peak|rms))?"


def value_name(text: str) -> str:
    """Return the name of a channel or of a statistic of one; raise ValueError for another text."""
    if not re.fullmatch(_VALUE, text):
        raise ValueError(
            f"got '{text}', expected a channel, such as meter.voltage, or a statistic of one,"
            " such as meter.voltage.rms"
        )
    return text


ValueName = Annotated[
    str, AfterValidator(value_name), Field(json_schema_extra={"pattern": f"^{_VALUE}$"})
]
"""A channel, 'role.name', or a statistic of its samples, 'role.name.rms'."""


Per = Annotated[
    ListOf[CoordinateKey],
    BeforeValidator(lambda value: [value] if isinstance(value, str) else value),
    WithJsonSchema({"anyOf": [_KEY, {"type": "array", "items": _KEY}]}),
]
"""One or several coordinates that distinguish results."""


class ResultSettings(Settings):
    """The name and unit of the result."""

    name: Annotated[str, Field(pattern=f"^{NAME}$")]
    """The name used by limits, report and certificate."""
    symbol: PlainText = ""
    """The symbol, such as R."""
    text: PlainText = ""
    """The measurand in words, such as 'load regulation'."""
    unit: UnitSymbol
    """The unit, such as mV."""
    id: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")] | None = None
    """The measurand's identifier in a shared list, such as voltage.dc.regulation."""

    def definition(self, per: tuple[str, ...]) -> ResultDefinition:
        """Return what the analysis yields: one result for each value of some coordinates."""
        return ResultDefinition(
            name=self.name,
            symbol=self.symbol,
            text=self.text,
            unit=self.unit,
            per=per,
            id=self.id or "",
        )


class ComparedRun(PartnerRun):
    """A run whose value is subtracted or divided by."""

    name: PartnerName
    """The name used by `--partner` and in documents."""
    per: Per | None = None
    """One value for each of these coordinates, which must be in the analysis' own `per`; `[]` for
    one value over all, which is the default if that run has only one value of each."""
    where: Place = Field(default_factory=dict)
    """Use only what was measured in that run under this condition."""


class TareRun(ComparedRun):
    """A run whose value is subtracted, such as a dark detector or an empty balance."""

    name: PartnerName = "tare"


class ReferenceRun(ComparedRun):
    """A run by whose value is divided, such as a run of a reference specimen."""

    name: PartnerName = "reference"


class ReadingsSettings(Settings):
    """A statistic of a recorded channel or of a column of measured values."""

    of: ValueName
    """The channel, such as meter.voltage, or a statistic that `record` stores, such as
    tester.torque.rms."""
    statistic: Statistic = "mean"
    """The statistic of the values in each group of `per`, or of all values."""
    minus: ValueName | None = None
    """A channel read at the same time: the statistic is taken of the differences, value by value.
    """
    divided_by: ValueName | None = None
    """A channel read at the same time: the statistic is taken of the quotients, value by value."""
    per: Per = ()
    """One result for each value of these set-points or coordinates, such as [load.current]."""
    where: Place = Field(default_factory=dict)
    """Use only what was measured under this condition, such as {load.current: 2 A}."""
    table: Annotated[str, Field(pattern=f"^{NAME}$")] | None = None
    """Use only the rows of this table; if omitted, the recordings, or all tables if there are none.
    """
    percent: Annotated[Ratio, Field(gt=0, lt=1)] | None = None
    """For `percentile`: the share of values at or below it, such as 95 %."""
    within: Difference | None = None
    """For `settling_time`: the half-width of the band around the last value."""
    tare: TareRun | None = None
    """Subtract the same statistic of another run, such as a dark reading."""
    relative_to: ReferenceRun | None = None
    """Divide by the same statistic of another run, such as a run of a reference specimen."""
    result: ResultSettings

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.tare is not None and self.relative_to is not None:
            raise ValueError("one of 'tare' and 'relative_to' is allowed, not both")
        if self.compared is not None and not set(self.compared.per or ()) <= set(self.per):
            raise ValueError("a partner run's 'per' names coordinates of the analysis' own 'per'")
        if self.minus is not None and self.divided_by is not None:
            raise ValueError("one of 'minus' and 'divided_by' is allowed, not both")
        for key, statistic in (("percent", "percentile"), ("within", "settling_time")):
            is_given = getattr(self, key) is not None
            if is_given and self.statistic != statistic:
                raise ValueError(f"'{key}' belongs to the statistic {statistic}")
            if not is_given and self.statistic == statistic:
                raise ValueError(f"the statistic {statistic} needs the key '{key}'")
        return self

    @property
    def channels(self) -> list[str]:
        """The channels that are read at the same time."""
        return [name for name in (self.of, self.minus, self.divided_by) if name is not None]

    @property
    def is_difference(self) -> bool:
        """Whether the result is a difference of values; of temperatures it is in K."""
        return bool(self.minus or self.compared or is_spread(self.of, self.statistic)) or (
            self.statistic in {"slope", "settling_time"}
        )

    @property
    def compared(self) -> ComparedRun | None:
        """The partner run whose value is subtracted or divided by."""
        return self.tare or self.relative_to

    def yields(self) -> tuple[ResultDefinition, ...]:
        """Return the one result."""
        return (self.result.definition(self.per),)

    def requires(self) -> Requirements:
        """Return the channels that it reads."""
        keys = (("of", self.of), ("minus", self.minus), ("divided_by", self.divided_by))
        channels = tuple(
            NeededChannel(name=name, key=(key,), enters=(self.result.name,))
            for key, name in keys
            if name is not None
        )
        partners: tuple[NeededRun, ...] = ()
        if self.compared is not None:
            key = ("tare",) if self.tare else ("relative_to",)
            needed = self.compared.needed(
                self.compared.name, key, channels=channels, at=tuple(self.compared.per or ())
            )
            partners = (needed,)
        return Requirements(channels=channels, partners=partners)

    def objections(self, units: Mapping[str, str]) -> Iterator[Objection]:
        """Yield an error for each setting that does not fit the units of the channels."""
        objections = list(self._unlike_channels(units))
        if objections:
            yield from objections
            return
        value = units[self.of]
        if self.divided_by is not None:
            try:
                value = quotient(value, units[self.divided_by])
            except QuantityError as error:
                yield ("divided_by",), error.message, error.hint
                return
        dimension = of_difference(unit(value).dimension)
        if self.within is not None and self.within.dimension != dimension:
            message = (
                f"got '{self.within}', {with_article(self.within.dimension)}; expected"
                f" {with_article(dimension)}"
            )
            yield ("within",), message, ""
        try:
            si = si_unit(self.statistic, value, is_difference=self.is_difference)
        except QuantityError as error:
            yield ("statistic",), error.message, error.hint
            return
        si = "1" if self.relative_to else si
        result = unit(self.result.unit)
        if result.dimension != unit(si).dimension:
            got = f"the {self.statistic} is {with_article(unit(si).dimension)}"
            if self.relative_to is not None:
                got = f"a quotient of two runs is {with_article(unit(si).dimension)}"
            message = f"got '{self.result.unit}', {with_article(result.dimension)}; {got}"
            hint = f"write a unit such as {unit(si).symbol}"
            if self.statistic == "slope":
                hint += "; a slope over a channel or set-point is a result of the analysis 'curve'"
            yield ("result", "unit"), message, hint
        elif result.offset and (self.minus or self.tare or is_spread(self.of, self.statistic)):
            yield (
                ("result", "unit"),
                f"got '{self.result.unit}', and the result is a difference of temperatures",
                "write K",
            )

    def _unlike_channels(self, units: Mapping[str, str]) -> Iterator[Objection]:
        """Yield an error for channels that cannot be subtracted or divided, nor squared.

        A level on a scale, such as -10 dBm, is a logarithm: it has no quotient and no mean square.
        """
        kind = unit(units[self.of]).dimension
        if self.minus is not None:
            other = unit(units[self.minus]).dimension
            if other != kind:
                message = (
                    f"{self.minus} is {with_article(other)}, and {self.of} {with_article(kind)}"
                )
                yield ("minus",), message, "subtract quantities of one kind"
            return
        if self.statistic == "integral" and not self.divided_by and kind in _POINTS_ON_A_SCALE:
            message = f"the integral of {with_article(kind)} depends on the zero of its scale"
            yield ("statistic",), message, "subtract another channel with 'minus'"
            return
        names = [self.of, *([self.divided_by] if self.divided_by else [])]
        kinds = {name: unit(units[name]).dimension for name in names}
        for name, kind in kinds.items():
            if of_difference(kind) == kind:
                continue
            message = f"{name} is {with_article(kind)}, a logarithm"
            if self.divided_by is not None:
                yield ("divided_by",), message, "'minus' gives the difference, in dB"
            elif self.relative_to is not None:
                yield ("relative_to",), message, "'tare' gives the difference, in dB"
            else:
                yield from unlike_rms(self.of, self.statistic, kind)
            return


def unit_of_errors(value: str) -> str:
    """Return the SI unit of errors of values in an SI unit: dB of dBm."""
    return si_symbol(of_difference(unit(value).dimension))


def unlike_rms(of: str, statistic: str, kind: str) -> Iterator[Objection]:
    """Yield an error for a root mean square of a logarithm, such as dBm."""
    if of_difference(kind) != kind and (statistic == "rms" or of.endswith(".rms")):
        key = "statistic" if statistic == "rms" else "of"
        yield (key,), f"{of} is {with_article(kind)}, a logarithm", "take the mean"


def is_spread(of: str, statistic: str) -> bool:
    """Return whether a statistic is a difference of values; of temperatures it is in K."""
    return statistic in {"range", "standard_deviation"} or of.endswith(".peak_to_peak")


def quotient(above: str, below: str) -> str:
    """Return the SI unit of the quotient of two SI units; raise QuantityError for none."""
    if unit(above).dimension == unit(below).dimension:
        return "1"
    if below == "1":
        return above
    divisor = f"({below})" if {"·", "/"} & set(below) else below
    if "/" in above or "/" in below:  # m/s over s: one quotient of products
        over, _, under = above.partition("/")
        below_over, _, below_under = below.partition("/")
        numerator = "·".join(filter(None, (over.strip("()"), below_under.strip("()"))))
        denominator = "·".join(filter(None, (under.strip("()"), below_over.strip("()"))))
        return unit(f"{numerator}/({denominator})" if "·" in denominator
                    else f"{numerator}/{denominator}").symbol  # fmt: skip
    return unit(f"{above}/{divisor}").symbol


def si_unit(statistic: str, value: str, *, is_difference: bool = False) -> str:
    """Return the SI unit of a statistic of values in an SI unit; dB of a difference of dBm."""
    if statistic == "settling_time":
        return "s"
    if statistic == "slope":
        return quotient(value, "s")
    if statistic == "integral":
        exponents = zip(exponents_of(unit(value).dimension), exponents_of("time"), strict=True)
        return si_symbol(kind_of(tuple(a + b for a, b in exponents)))
    assert is_coherent(unit(value)), value  # noqa: S101  (values are in SI units)
    return unit_of_errors(value) if is_difference else value
