"""Settings of the analysis `equation`. Does not import numpy."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cached_property
from math import inf, sqrt
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from rigrunner.api import (
    AnyQuantity,
    ListOf,
    Member,
    NeededChannel,
    Quantity,
    Requirements,
    Settings,
    YesNo,
    unit,
)
from rigrunner.api.analysis.requirements import NeededResult
from rigrunner.api.member import NAME
from rigrunner.api.places import Place
from rigrunner.api.settings import Difference
from rigrunner.api.units import of_difference, si_symbol, with_article
from rigrunner_plugins.analyses.equation.kinds import TURNS, Kind, KindError, kind_of_node
from rigrunner_plugins.analyses.equation.text import RESERVED, read
from rigrunner_plugins.analyses.settings import Per, ResultSettings

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

    from rigrunner.api import Objection, ResultDefinition
    from rigrunner_plugins.analyses.equation.text import Model


class _PartError(ValueError):
    """What is wrong with a part of the settings, which is known by comparing it with others."""

    def __init__(self, message: str, *key: str | int) -> None:
        super().__init__(message)
        self.key = key
        """Where the part stands."""


Symbol = Annotated[str, Field(pattern=f"^{NAME}$")]
"""The symbol of a quantity in the model."""
OVER_U = {"rectangular": sqrt(3), "triangular": sqrt(6), "arcsine": sqrt(2)}
"""Half-width divided by standard uncertainty (JCGM 101:2008, table 1)."""
_PLUS_MINUS = "±"
_ROUNDING = 1e-9
_THERMODYNAMIC = 200.0
"""Offset in K from which a shift of a temperature may be meant as a temperature."""


def _width(value: object) -> object:
    """Return '±0.02 K' as the quantity 0.02 K, and '±2 %' as a share of the value."""
    if isinstance(value, str) and value.strip().startswith((_PLUS_MINUS, "+/-")):
        return value.strip().removeprefix(_PLUS_MINUS).removeprefix("+/-").strip()
    return value


def _number(value: object) -> object:
    """Return a bare number as a dimensionless quantity."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return Quantity(float(value), unit("1"))
    return value


Number = WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "number"}]})
Value = Annotated[AnyQuantity, BeforeValidator(_number), Number]
"""A number with its unit; a bare number is dimensionless."""
Width = Annotated[Difference, BeforeValidator(_number), BeforeValidator(_width), Number]
"""A half-width or an uncertainty above zero; '±' may stand before it."""


class ConstantSettings(Settings):
    """A quantity known in advance, with its uncertainty."""

    value: Value
    """The value, such as 20 °C; without an uncertainty it is exact."""
    limits: Width | None = None
    """The half-width of its limits."""
    distribution: Literal["rectangular", "triangular", "arcsine", "normal"] | None = None
    """The distribution: by default rectangular for limits, and normal for `u` and `U`."""
    U: Width | None = None
    """The expanded uncertainty; state `k` too."""
    k: Annotated[float, Field(gt=0, le=10)] | None = None
    """The coverage factor of `U`."""
    u: Width | None = None
    """The standard uncertainty."""
    degrees_of_freedom: Annotated[float, Field(gt=0, le=1e9)] | None = None
    """The degrees of freedom of the uncertainty; if omitted, infinite."""

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        given_keys = [key for key in ("limits", "U", "u") if getattr(self, key) is not None]
        if len(given_keys) > 1:
            raise ValueError(f"one of {' and '.join(given_keys)} is enough")
        if (self.U is None) != (self.k is None):
            raise ValueError("'U' and 'k' belong together")
        if not given_keys and (self.distribution or self.degrees_of_freedom):
            raise ValueError("an exact constant has neither distribution nor degrees of freedom")
        if self.limits is not None and self.distribution == "normal":
            raise ValueError("limits bound it: for a normal distribution give 'u', or 'U' with 'k'")
        for key in given_keys:
            width = getattr(self, key)
            is_share = width.dimension == "ratio" and width.unit.symbol != "1"
            kinds_of_width = {self.value.dimension, of_difference(self.value.dimension)}
            if width.dimension not in kinds_of_width and not is_share:
                kinds = [with_article(quantity.dimension) for quantity in (width, self.value)]
                raise ValueError(f"{key}: '{width}' is {kinds[0]}, and the value {kinds[1]}")
            if width.dimension != self.value.dimension and self.value.unit.offset:
                raise ValueError(f"{key}: of a temperature it is a difference in K")
        return self

    def of_two_meanings(self) -> tuple[str, str, str] | None:
        """Return the key of a width such as '10 %' of the number 3, what it may mean, and a hint.

        It counts as 0.1, and a person may mean 10 % of 3. Of 10 dBm, 10 % may be of the power.
        """
        value, difference = self.value, of_difference(self.value.dimension)
        for key in ("limits", "U", "u"):
            width = getattr(self, key)
            if width is not None and difference not in {value.dimension, width.dimension}:
                hint = f"write it in {si_symbol(difference)}"
                return key, f"'{width}' is no difference of two {value.dimension}s", hint
            if width is None or value.unit.symbol != "1" or width.unit.symbol == "1":
                continue
            share = width.si * abs(value.si)
            if share != width.si:
                message = f"'{width}' of the number {value.si:g}: a share of it, or {width.si:g}?"
                return key, message, f"write {share:g} or {width.si:g}"
        return None

    @property
    def shape(self) -> str:
        """The name of its `Distribution`."""
        return self.distribution or ("normal" if self.limits is None else "rectangular")

    @property
    def standard_uncertainty(self) -> float:
        """The standard uncertainty in the SI unit; 0 for an exact value."""
        if self.limits is not None:
            return self._si(self.limits) / OVER_U[self.shape]
        if self.U is not None and self.k is not None:
            return self._si(self.U) / self.k
        return 0.0 if self.u is None else self._si(self.u)

    @property
    def dof(self) -> float:
        """The degrees of freedom of the uncertainty."""
        return inf if self.degrees_of_freedom is None else self.degrees_of_freedom

    def _si(self, width: Quantity) -> float:
        if width.dimension == "ratio" != self.value.dimension:
            return width.si * abs(self.value.si)
        return width.si


def _source(value: str) -> str:
    """Return the name of a result or of a channel."""
    return value if re.fullmatch(NAME, value) else Member.parse(value)


class InputSettings(Settings):
    """A channel whose readings enter the model, or a result of another analysis."""

    of: Annotated[str, AfterValidator(_source)]
    """The channel or set-point, such as meter.voltage, or the name of a result, such as
    resistance."""
    instrument: YesNo = True
    """Whether the register gives the instrument's errors; if not, state them as constants."""
    scatter: Width | None = None
    """The standard deviation of a reading, known from earlier readings (GUM 4.2.4)."""
    degrees_of_freedom: Annotated[float, Field(gt=0, le=1e9)] | None = None
    """The degrees of freedom of `scatter`; if omitted, infinite."""

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.scatter is None and self.degrees_of_freedom is not None:
            raise ValueError("'degrees_of_freedom' belongs to 'scatter'")
        if not self.is_channel and (self.scatter is not None or not self.instrument):
            raise ValueError("'instrument' and 'scatter' belong to a channel; this is a result")
        return self

    @property
    def is_channel(self) -> bool:
        """Whether it is a channel; otherwise it is a result of another analysis."""
        return isinstance(self.of, Member)


class CorrelationSettings(Settings):
    """The correlation of the errors of two inputs or constants."""

    between: Annotated[ListOf[Symbol], Field(min_length=2, max_length=2)]
    """Two constants, or two inputs; for inputs, the errors of their instruments are correlated."""
    r: Annotated[float, Field(ge=-1, le=1)]
    """The correlation coefficient."""


def _in_braces(key: str) -> BeforeValidator:
    """Return a text as a mapping that has it under a key."""

    def read_one(value: object) -> object:
        return value if isinstance(value, (dict, Settings)) else {key: value}

    return BeforeValidator(read_one)


class _OrAlone:
    """Tells editors that a single value may replace the mapping."""

    def __init__(self, *types: str) -> None:
        self.types = types

    def __get_pydantic_json_schema__(
        self, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [*({"type": type_} for type_ in self.types), handler(core_schema)]}


Constant = Annotated[ConstantSettings, _in_braces("value"), _OrAlone("string", "number")]
AnyInput = Annotated[InputSettings, _in_braces("of"), _OrAlone("string")]


class EquationSettings(Settings):
    """A measurement model: its equations, inputs and results."""

    result: ResultSettings | None = None
    """The name and unit of the only result."""
    results: ListOf[ResultSettings] = ()
    """The names and units of several results that share their inputs."""
    inputs: Annotated[Mapping[Symbol, AnyInput], Field(min_length=1, max_length=30)]
    """The channels by their symbols in the model; all are measured at one step together. A
    set-point that is not read counts as exact if it is not in the register. A name without a dot is
    a result of another analysis, with its uncertainty."""
    constants: Annotated[Mapping[Symbol, Constant], Field(max_length=50)] = Field(
        default_factory=dict
    )
    """Quantities known in advance, such as {t0: 20 °C}."""
    correlations: ListOf[CorrelationSettings] = ()
    """Correlated inputs and constants, beyond the correlation that the readings show."""
    model: Annotated[str, Field(min_length=1)]
    """The equation, such as R = U / I; for several results, one line each."""
    per: Per = ()
    """One result for each value of these set-points or coordinates, such as [load.current]."""
    where: Place = Field(default_factory=dict)
    """Use only what was measured under this condition, such as {load.current: 2 A}."""
    table: Annotated[str, Field(pattern=f"^{NAME}$")] | None = None
    """Use only the rows of this table; if omitted, the recordings, or all tables if there are none.
    """
    second_order: YesNo | None = None
    """Whether to include second-order terms; if omitted, only if they change the displayed u."""

    @field_validator("inputs", "constants")
    @classmethod
    def _are_no_functions(cls, value: Mapping[str, Any]) -> Mapping[str, Any]:
        for name in value:
            if name in RESERVED:
                raise ValueError(f"'{name}' is a name of the language; choose another one")
        return value

    @field_validator("model")
    @classmethod
    def _is_read(cls, model: str, info: ValidationInfo) -> str:
        fields = info.data
        if {"result", "results", "inputs", "constants"} <= fields.keys():
            results = _all_results(fields["result"], fields["results"])
            if results:
                result_names = [symbol_of(result) for result in results]
                read(model, {*fields["inputs"], *fields["constants"]}, result_names)
        return model

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if (self.result is None) == (not self.results):
            raise ValueError("one of 'result' and 'results' is needed")
        names = [result.name for result in self.all_results]
        symbols = [symbol_of(result) for result in self.all_results]
        if len(set(names)) < len(names) or len(set(symbols)) < len(symbols):
            raise ValueError("two results have one name or symbol")
        twice = set(self.inputs) & set(self.constants)
        if twice:
            raise _PartError(f"'{min(twice)}' is an input and a constant", "constants", min(twice))
        used = {name for equation in self.parsed.equations for name in equation.expression.names()}
        unused = [name for name in (*self.inputs, *self.constants) if name not in used]
        if unused:
            key = "inputs" if unused[0] in self.inputs else "constants"
            raise _PartError(f"the model does not use '{unused[0]}'", key, unused[0])
        for index, correlation in enumerate(self.correlations):
            self._refuse_correlation(index, *correlation.between)
        self._refuse_impossible()
        return self

    def _refuse_impossible(self) -> None:
        """Raise ValueError if the correlation matrix is not positive semidefinite."""
        names = list(dict.fromkeys(name for pair in self.correlations for name in pair.between))
        r = {frozenset(pair.between): pair.r for pair in self.correlations}
        rows = [[1.0 if a == b else r.get(frozenset((a, b)), 0.0) for b in names] for a in names]
        for k, row in enumerate(rows):  # the pivots of Gauss are those of Cholesky, squared
            remains = row[k] <= _ROUNDING and any(abs(value) > _ROUNDING for value in row[k:])
            if row[k] < -_ROUNDING or remains:
                raise _PartError(
                    f"{', '.join(names)} cannot have these correlations together", "correlations"
                )
            for below in rows[k + 1 :]:
                share = below[k] / row[k] if row[k] > _ROUNDING else 0.0
                below[:] = [value - share * above for value, above in zip(below, row, strict=True)]

    def _refuse_correlation(self, index: int, one: str, other: str) -> None:
        key = ("correlations", index, "between")
        names = {*self.inputs, *self.constants}
        for name in (one, other):
            if name not in names:
                raise _PartError(f"there is no '{name}'", *key)
        pairs = [set(correlation.between) for correlation in self.correlations]
        if one == other or pairs.count({one, other}) > 1:
            raise _PartError(f"'{one}' and '{other}' are named twice", *key)
        if (one in self.inputs) != (other in self.inputs):
            raise _PartError("an input and a constant; expected two of one kind", *key)
        if any(name in self.from_results for name in (one, other)):
            raise _PartError("how results are correlated follows from their budgets", *key)
        if one in self.constants:
            first, second = self.constants[one], self.constants[other]
            if not (first.standard_uncertainty and second.standard_uncertainty):
                raise _PartError("an exact constant cannot be correlated", *key)
            if first.dof != second.dof:
                raise _PartError(
                    "their degrees of freedom differ, but must be those of one estimation", *key
                )

    @property
    def all_results(self) -> tuple[ResultSettings, ...]:
        """The results, in the order of the procedure."""
        return _all_results(self.result, self.results)

    @cached_property
    def parsed(self) -> Model:
        """The parsed model."""
        names = {*self.inputs, *self.constants}
        return read(self.model, names, [symbol_of(result) for result in self.all_results])

    @property
    def channels(self) -> Mapping[str, InputSettings]:
        """The inputs that are channels or set-points."""
        return {name: source for name, source in self.inputs.items() if source.is_channel}

    @property
    def from_results(self) -> Mapping[str, InputSettings]:
        """The inputs that are results of other analyses."""
        return {name: source for name, source in self.inputs.items() if not source.is_channel}

    def yields(self) -> tuple[ResultDefinition, ...]:
        """Return the results."""
        return tuple(result.definition(self.per) for result in self.all_results)

    def requires(self) -> Requirements:
        """Return the channels and the results of other analyses that the model reads."""
        return Requirements(
            channels=tuple(
                NeededChannel(
                    name=source.of,
                    key=("inputs", name),
                    enters=tuple(result.name for result in self.all_results)
                    if source.instrument
                    else (),
                    or_coordinate=True,
                )
                for name, source in self.channels.items()
            ),
            results=tuple(
                NeededResult(
                    name=source.of,
                    key=("inputs", name),
                    per=(*self.per, *self.where),
                    independent=True,
                )
                for name, source in self.from_results.items()
            ),
        )

    def objections(self, units: Mapping[str, str]) -> Iterator[Objection]:
        """Yield an error for each part that does not fit the units of its inputs."""
        kinds = {name: Kind.of_unit(units[source.of], is_channel=source.is_channel)
                 for name, source in self.inputs.items()}  # fmt: skip
        for name, source in self.inputs.items():
            dimension = unit(units[source.of]).dimension
            if source.scatter and source.scatter.dimension != of_difference(dimension):
                message = f"got '{source.scatter}', and {source.of} is {with_article(dimension)}"
                hint = "it is the standard deviation of a reading"
                yield ("inputs", name, "scatter"), message, hint
        quantities = {name: constant.value for name, constant in self.constants.items()} | dict(
            self.parsed.literals
        )
        kinds |= {name: Kind.of_unit(quantity.unit.symbol) for name, quantity in quantities.items()}
        for name, constant in self.constants.items():
            if ambiguity := constant.of_two_meanings():
                key, message, hint = ambiguity
                yield ("constants", name, key), message, hint
        for name, quantity in quantities.items():
            may_be_temperature = quantity.unit.symbol == "K" and abs(quantity.si) >= _THERMODYNAMIC
            if may_be_temperature and any(kind.scale == "temperature" for kind in kinds.values()):
                yield (
                    ("constants", name) if name in self.constants else ("model",),
                    f"'{quantity}' beside temperatures in °C: a difference, or a temperature?",
                    f"write the temperature in °C: {quantity.si - 273.15:g} °C",
                )
                return
        yield from self._misfits(kinds)

    def _misfits(self, kinds: dict[str, Kind]) -> Iterator[Objection]:
        results = {symbol_of(result): result for result in self.all_results}
        for equation in self.parsed.equations:
            root = equation.expression.root
            try:
                kind = kind_of_node(root, kinds)
            except KindError as error:
                column = self.parsed.column(error.node)
                message = f"column {column}: {error.message}"
                yield ("model",), message, error.hint, column
                return
            if equation.name in results:
                yield from self._misfit_of_unit(results[equation.name], kind)
                stated = Kind.of_unit(results[equation.name].unit)
                kind = stated if stated.is_level or not (kind.scale or kind.fits(stated)) else kind
            kinds[equation.name] = kind

    def _misfit_of_unit(self, result: ResultSettings, kind: Kind) -> Iterator[Objection]:
        stated = Kind.of_unit(result.unit)
        at = ("result", "unit") if self.result else (
            "results", self.all_results.index(result), "unit")  # fmt: skip
        if kind.scale == "temperature" and stated == Kind.of_unit("K"):
            return  # the thermodynamic temperature
        if stated.scale and not kind.scale and kind.fits(stated.difference):
            hint = f"write {si_symbol(of_difference(stated.scale))}"
            if stated.scale == "power level":
                hint = "write dB, or add number(0, dBm)"
            yield at, f"got '{result.unit}', and the model gives a difference", hint
        elif not kind.fits(stated) or (kind.is_level and not stated.is_level):
            dimension = with_article(unit(result.unit).dimension)
            hint = TURNS if kind.is_a_turn_off(stated) else "write dB" if kind.is_level else ""
            yield at, f"got '{result.unit}', {dimension}; the model gives {kind.words}", hint


def _all_results(
    only: ResultSettings | None, several: tuple[ResultSettings, ...]
) -> tuple[ResultSettings, ...]:
    return several if only is None else (only,)


def symbol_of(result: ResultSettings) -> str:
    """Return a result's symbol in the model; its name if it has no usable symbol."""
    symbol = result.symbol
    return symbol if symbol.isascii() and symbol.isidentifier() else result.name
