"""Settings of the analysis `curve`. Does not import numpy."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema, model_validator

from rigrunner.api import (
    AnyQuantity,
    ListOf,
    NeededChannel,
    QuantityError,
    Requirements,
    Settings,
    YesNo,
    find_unit,
    unit,
)
from rigrunner.api.analysis.requirements import NeededResult
from rigrunner.api.errors import did_you_mean
from rigrunner.api.fit_choice import FitChoice
from rigrunner.api.member import NAME
from rigrunner.api.places import CoordinateKey, Place, PlaceValue
from rigrunner.api.settings import OneOrSeveral
from rigrunner.api.units import si_symbol, with_article
from rigrunner_plugins.analyses.settings import (
    Per,
    ResultSettings,
    is_spread,
    quotient,
    unit_of_errors,
    unlike_rms,
    value_name,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api import Objection, Quantity, ResultDefinition

_Path = tuple[str | int, ...]
_KEY = f"^{NAME}([.]{NAME}){{0,2}}$"
BOTH_WAYS = 2
"""Number of directions of a hysteresis: rising and falling."""
SAME_X = 0.01
"""Share of the range of x within which two values count as the same x."""


def _source(text: str) -> str:
    """Return the name of a result or of a channel."""
    return text if re.fullmatch(NAME, text) else value_name(text)


def _regressors(value: object) -> object:
    return {"x": value} if isinstance(value, str) else value


Regressors = Annotated[
    Mapping[str, Annotated[str, Field(pattern=_KEY)]],
    BeforeValidator(_regressors),
    Field(min_length=1),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string", "pattern": _KEY},
                {"type": "object", "additionalProperties": {"type": "string", "pattern": _KEY}},
            ]
        }
    ),
]


class ValueAt(ResultSettings):
    """The curve at one x."""

    at: Annotated[
        AnyQuantity | Mapping[str, AnyQuantity],
        Field(description="x; of several regressors a value for each by its name"),
    ]
    extrapolate: YesNo = False
    """Whether x may be outside the points; the result then carries a note."""


class XAt(ResultSettings):
    """The x at which the curve reaches y, for inverse use of a calibration."""

    y: AnyQuantity | None = None
    """A fixed value; otherwise use `where`."""
    readings: Annotated[int, Field(ge=1)] | None = None
    """Number of readings of the same instrument averaged in `y`; if omitted, y is exact."""
    where: Place = Field(default_factory=dict)
    """Use the mean of the readings selected by this, such as {phase: unknown}, in place of `y`."""

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.y is None) == (not self.where):
            raise ValueError("one of 'y' and 'where' is needed")
        if self.where and self.readings is not None:
            raise ValueError("'readings' belongs to 'y': those of 'where' are counted")
        return self


class Slope(ResultSettings):
    """The slope of the curve."""

    at: AnyQuantity | None = None
    """The x of the slope; if omitted, the mean slope over the range of the points."""


class Deviation(ResultSettings):
    """The greatest deviation of y."""

    of_span: YesNo = False
    """Whether it is stated as a percentage of the span of y."""


class Nonlinearity(Deviation):
    """The greatest deviation of the mean values at each x from the best straight line."""


class BothWays(Deviation):
    """A difference between rising and falling x."""

    between: Annotated[
        Mapping[CoordinateKey, ListOf[PlaceValue]],
        Field(
            min_length=1,
            max_length=1,
            description="the label and its values: first rising, then falling x",
        ),
    ]

    @model_validator(mode="after")
    def _two_values(self) -> Self:
        if len(self.ways) != BOTH_WAYS:
            raise ValueError(
                f"got {len(self.ways)} values, expected {BOTH_WAYS}: rising and falling"
            )
        return self

    @property
    def label(self) -> str:
        """The label that states the direction of x."""
        return next(iter(self.between))

    @property
    def ways(self) -> tuple[Quantity | str, ...]:
        """The values of the label for rising and falling x."""
        return next(iter(self.between.values()))


class Hysteresis(BothWays):
    """The greatest absolute difference of y, falling minus rising, at one x."""


class ZeroReturn(BothWays):
    """The change of y at the x nearest to zero: after x returned, minus before."""


class CurveResults(Settings):
    """The results to state; one of each kind, or a list of several."""

    parameters: Annotated[
        Mapping[str, ResultSettings],
        Field(description="parameters of the fit by name, such as c0 and c1 of a polynomial"),
    ] = Field(default_factory=dict)
    value: OneOrSeveral[ValueAt] = ()
    """The curve at one x."""
    x_at: OneOrSeveral[XAt] = ()
    """The x at which the curve reaches y, for inverse use of a calibration."""
    slope: OneOrSeveral[Slope] = ()
    """The slope of the curve."""
    nonlinearity: OneOrSeveral[Nonlinearity] = ()
    """The greatest deviation from the best straight line."""
    hysteresis: OneOrSeveral[Hysteresis] = ()
    """The greatest difference of y at one x, falling minus rising."""
    zero_return: OneOrSeveral[ZeroReturn] = ()
    """The change of y after x returned to zero."""

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if not any(True for _ in self.all_of()):
            raise ValueError(f"no result is named; there are: {', '.join(type(self).model_fields)}")
        return self

    def all_of(self) -> Iterator[tuple[_Path, ResultSettings]]:
        """Yield each result with its key."""
        for name, result in self.parameters.items():
            yield ("parameters", name), result
        for key in type(self).model_fields:
            results = () if key == "parameters" else getattr(self, key)
            for index, result in enumerate(results):
                yield ((key, index) if len(results) > 1 else (key,)), result


class CurveSettings(Settings):
    """Fits a curve through y over x and derives results from it."""

    of: Annotated[str, AfterValidator(_source), Field(json_schema_extra={"pattern": _KEY})]
    """The channel of y, such as meter.voltage, a statistic of a channel that `record` stores, or a
    result of another analysis, such as head."""
    over: Annotated[
        Regressors,
        Field(
            description="x: a channel that is read with y, or a set-point, counter or label; of a"
            " result, another result or a set-point of its 'per'; several with names: {load:"
            " press.force, speed: drive.speed}"
        ),
    ]
    fit: FitChoice
    """The fit, such as {polynomial: {degree: 1}}."""
    statistic: Literal["mean", "minimum", "maximum", "range", "rms"] = "mean"
    """The statistic taken of each recording; a table row has one value."""
    reference: AnyQuantity | None = None
    """The origin of x; if omitted, zero, or 0 °C for a temperature."""
    per: Per = ()
    """Fit one curve for each value of these set-points or coordinates."""
    where: Place = Field(default_factory=dict)
    """Use only what was measured under this condition, such as {phase: calibration}."""
    table: Annotated[str, Field(pattern=f"^{NAME}$")] | None = None
    """Use only the rows of this table; if omitted, the recordings, or all tables if there are none.
    """
    results: CurveResults

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(self.over) > 1:
            results = self.results
            for_one_x = (results.x_at, results.slope, results.nonlinearity, results.hysteresis,
                     results.zero_return)  # fmt: skip
            if any(for_one_x) or self.reference is not None:
                raise ValueError(
                    "with several regressors only 'parameters' and 'value' are known; "
                    "'reference' needs one regressor too"
                )
        for value in self.results.value:
            if isinstance(value.at, Mapping) and set(value.at) != set(self.over):
                raise ValueError(f"'at' of {value.name} needs a value for {', '.join(self.over)}")
            if not isinstance(value.at, Mapping) and len(self.over) > 1:
                raise ValueError(f"'at' of {value.name} is a mapping: {', '.join(self.over)}")
        if self.is_of_results:
            if self.statistic != "mean" or self.table is not None:
                raise ValueError(f"'statistic' and 'table' belong to a channel; {self.of} is none")
            if any(x_at.where or x_at.readings for x_at in self.results.x_at):
                raise ValueError(f"'x_at' of a result, such as {self.of}, needs a fixed 'y' alone")
        return self

    @property
    def is_of_results(self) -> bool:
        """Whether y is a result of another analysis, not a channel."""
        return "." not in self.of

    @property
    def x_results(self) -> tuple[str, ...]:
        """The x that are results of other analyses."""
        of_run = {"elapsed", "cycles"}  # every row and recording has them
        names = (name for name in self.over.values() if "." not in name and name not in of_run)
        return tuple(names) if self.is_of_results else ()

    def at(self, value: ValueAt) -> Mapping[str, Quantity]:
        """Return the x of a value by the names of the regressors."""
        return value.at if isinstance(value.at, Mapping) else {next(iter(self.over)): value.at}

    def yields(self) -> tuple[ResultDefinition, ...]:
        """Return the results, in the order of the settings."""
        return tuple(result.definition(self.per) for _, result in self.results.all_of())

    def requires(self) -> Requirements:
        """Return the channels and coordinates to read, and the range that x must cover."""
        names = tuple(result.name for _, result in self.results.all_of())
        has_several_x = len(self.over) > 1
        set_x = {name: source for name, source in self.over.items() if source not in self.x_results}
        ways = [(key, way) for key, way in self.results.all_of() if isinstance(way, BothWays)]
        channels = (
            *(
                ()
                if self.is_of_results
                else (NeededChannel(name=self.of, key=("of",), enters=names),)
            ),
            *(
                NeededChannel(
                    name=source,
                    key=("over", name) if has_several_x else ("over",),
                    enters=names,
                    or_coordinate=True,
                    spans=self._span(name),
                    x_of="" if has_several_x else "fit",
                )
                for name, source in set_x.items()
            ),
            *(
                NeededChannel(
                    name=way.label,
                    key=("results", *key, "between"),
                    or_coordinate=True,
                    values=way.ways,
                    shared=next(iter(set_x.values()), ""),
                    within=SAME_X,
                )
                for key, way in ways
            ),
        )
        labels = [way.label for _, way in ways]
        coordinates = tuple(dict.fromkeys((*set_x.values(), *labels, *self.per, *self.where)))
        results = (
            *(
                (NeededResult(name=self.of, key=("of",), for_each=coordinates),)
                if self.is_of_results
                else ()
            ),
            *(
                NeededResult(
                    name=source,
                    key=("over", name) if has_several_x else ("over",),
                    for_each_of=self.of,
                )
                for name, source in self.over.items()
                if source in self.x_results
            ),
        )
        return Requirements(channels=channels, results=results)

    def _span(self, regressor: str) -> tuple[float, float] | None:
        """Return the least and the greatest requested x; None if none is requested."""
        at = [self.at(value)[regressor].si for value in self.results.value if not value.extrapolate]
        return (min(at), max(at)) if at else None

    def objections(self, units: Mapping[str, str]) -> Iterator[Objection]:
        """Yield an error for each setting that does not fit the units of y and x; '' is no unit."""
        # results have their own
        units = {name: _coherent(symbol) for name, symbol in units.items()}
        is_difference = is_spread(self.of, self.statistic)
        y = units[self.of]
        error_unit = unit_of_errors(y)
        y = error_unit if is_difference else y
        x = {name: units[source] or "1" for name, source in self.over.items()}
        only_x = next(iter(x.values()))
        yield from _misfit_of_quantity(("reference",), self.reference, only_x)
        yield from self._unlike_fit(units)
        yield from unlike_rms(self.of, self.statistic, unit(units[self.of]).dimension)
        for key, result in self.results.all_of():
            path: _Path = ("results", *key)
            if isinstance(result, ValueAt):
                for name, value in self.at(result).items():
                    subkey = (name,) if isinstance(result.at, Mapping) else ()
                    yield from _misfit_of_quantity((*path, "at", *subkey), value, x[name])
                yield from _misfit_of_unit(path, result, y, difference=is_difference)
            elif isinstance(result, XAt):
                yield from _misfit_of_quantity((*path, "y"), result.y, y)
                yield from _misfit_of_unit(path, result, only_x)
            elif isinstance(result, Slope):
                yield from _misfit_of_quantity((*path, "at"), result.at, only_x)
                yield from _misfit_of_slope(path, result, y, only_x)
            elif isinstance(result, Deviation):
                expected = "1" if result.of_span else error_unit
                yield from _misfit_of_unit(path, result, expected, difference=True)

    def _unlike_fit(self, units: Mapping[str, str]) -> Iterator[Objection]:
        """Yield an error for each parameter that the fit does not have, or has in another unit."""
        for name, result in self.results.parameters.items():
            if unit(result.unit).offset:  # which parameter is a temperature only the fit knows
                symbol = si_symbol(unit(result.unit).dimension)
                hint = f"write {symbol}; the curve at an x is a 'value', in {result.unit} too"
                message = f"got '{result.unit}', and a parameter may be a difference"
                yield ("results", "parameters", name, "unit"), message, hint
        names = [key.removeprefix("fit.") for key in units if key.startswith("fit.")]
        for name, result in self.results.parameters.items() if names else ():
            path = ("results", "parameters", name)
            if name not in names:
                hint = did_you_mean(name, names, f"it has: {', '.join(names)}")
                yield path, f"the fit has no parameter '{name}'", hint
                continue
            symbol = units[f"fit.{name}"]
            fit_dimension = unit(symbol or result.unit).dimension
            dimension = unit(result.unit).dimension
            if dimension != fit_dimension and symbol != "1":
                message = (
                    f"got '{result.unit}', {with_article(dimension)}; the fit begins with it in"
                    f" {symbol}, {with_article(fit_dimension)}"
                )
                yield (*path, "unit"), message, ""


def _coherent(symbol: str) -> str:
    unit_ = find_unit(symbol)
    return symbol if unit_ is None else si_symbol(unit_.dimension)


def _misfit_of_quantity(key: _Path, quantity: Quantity | None, si: str) -> Iterator[Objection]:
    dimension = unit(si).dimension
    if quantity is not None and quantity.dimension != dimension:
        got, expected = with_article(quantity.dimension), with_article(dimension)
        yield key, f"got '{quantity}', {got}; expected {expected}", ""


def _misfit_of_slope(path: _Path, result: Slope, y: str, x: str) -> Iterator[Objection]:
    try:
        yield from _misfit_of_unit(path, result, quotient(y, x))
    except QuantityError as error:
        yield (*path, "unit"), error.message, error.hint


def _misfit_of_unit(
    path: _Path, result: Any, si: str, *, difference: bool = False
) -> Iterator[Objection]:
    stated, expected = unit(result.unit), unit(si)
    if stated.dimension != expected.dimension:
        symbol = "%" if expected.symbol == "1" else expected.symbol
        hint = f"write a unit such as {symbol}"
        if isinstance(result, Deviation) and stated.dimension == unit("1").dimension:
            hint += ", or 'of_span: yes' for a share of the span"
        message = (
            f"got '{result.unit}', {with_article(stated.dimension)}; it is"
            f" {with_article(expected.dimension)}"
        )
        yield (*path, "unit"), message, hint
    elif difference and stated.offset:
        message = f"got '{result.unit}', and the result is a difference of temperatures"
        yield (*path, "unit"), message, "write K"
