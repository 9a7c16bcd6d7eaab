"""What a result may be, of any quantity: which one, where, and who says so."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, ValidationError, model_validator
from pydantic_core import core_schema

from rigrunner.api.errors import DataError, PluginError
from rigrunner.api.measurands import LimitedMeasurand
from rigrunner.api.names import Name, Text
from rigrunner.api.places import CoordinateKey, Places, is_in, places_text
from rigrunner.api.quantity import Quantity
from rigrunner.api.settings import Settings, YesNo
from rigrunner.api.units import unit, with_article
from rigrunner.api.verdict import Limits
from rigrunner.procedure.following import End, Line, Table
from rigrunner.procedure.kinds import ASKED, STORED, measurand_models, read_with_key

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from pydantic import GetCoreSchemaHandler

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.findings import ResultDefinition
    from rigrunner.api.measurands import ResultMeasurand


MEASURAND = "x-measurand"
"""Marks, in the JSON Schema, the key that models of analyses describe."""


@dataclass(frozen=True)
class UnreadMeasurand:
    """The key `measurand` as it is written: no analysis that could read it is installed here."""

    written: Mapping[str, object]

    def __str__(self) -> str:
        """Return it in one line: '{scale: HRC, load: 1471 N}'."""
        return f"{{{', '.join(f'{key}: {value}' for key, value in self.written.items())}}}"

    def objection(self, found: ResultMeasurand) -> str:
        """Return that its kind is not known here."""
        return (
            f"no analysis here can read the limit's measurand {self}, and the result is the {found}"
        )

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it."""
        return dict(self.written)

    def document(self) -> dict[str, object]:
        """Return its part of `result.json`."""
        return {**self.written, "text": str(self)}


class MeasurandKey:
    """Reads the key `measurand` of a limit by the model that an analysis names."""

    @classmethod
    def inside(cls, name: str) -> type[Settings] | None:
        """Return the model of that name, which stands in the place of an error; None for none."""
        return next((model for model in measurand_models({}) if model.__name__ == name), None)

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Let a model read it, by the analyses in the context of the validation."""
        mapping = core_schema.dict_schema(core_schema.str_schema(), core_schema.any_schema())
        return core_schema.with_info_after_validator_function(cls._read, mapping)

    @staticmethod
    def _read(value: dict[str, object], info: core_schema.ValidationInfo) -> LimitedMeasurand:
        """Return it as the first model has it that takes it; else raise what the first one says.

        Of a stored run, whose plugins may be missing here or of another version, it is kept.
        """
        context, first_error = info.context or {}, None
        for model in measurand_models(context):
            try:
                measurand: LimitedMeasurand = read_with_key(model.__name__, model, value, context)
            except ValidationError as error:
                first_error = first_error or error
            else:
                _require_json(measurand)
                return measurand
        if first_error is not None and not context.get(STORED):
            raise first_error
        return UnreadMeasurand(value)


class Limit(Settings):
    """Limits of a result of an analysis, with their source."""

    of: Name
    """The name of the result, as the analysis gives it."""
    where: Places = Field(default_factory=dict)
    """Only the results at these coordinates, such as {load.current: 2 A} or [1 A, 2 A]; if omitted,
    all."""
    except_: Annotated[Places, Field(alias="except")] = Field(default_factory=dict)
    """Except the results at these coordinates, such as those with another limit."""
    each: CoordinateKey | None = None
    """Each result over this coordinate must be within the limit."""
    mean: YesNo = False
    """The mean of the results must be within the limit."""
    worst: YesNo = False
    """The worst result by the rule must be within the limit: one verdict for all, with its
    place."""
    max: End | None = None
    """Upper limit; a mapping if it depends on a coordinate."""
    min: End | None = None
    """Lower limit; a mapping if it depends on a coordinate."""
    plus_minus: End | None = None
    """In place of both: greatest amount of a difference, such as a deviation."""
    measurand: Annotated[
        Annotated[LimitedMeasurand, MeasurandKey] | None, Field(json_schema_extra={MEASURAND: True})
    ] = None
    """The quantity that the limit applies to; required if the result states one, else refused."""
    source: Text
    """Source of the limit: a standard with its edition, a drawing, an agreement."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if not self.ends:
            raise ValueError("a limit needs max, min, or both, or plus_minus")
        if self.plus_minus is not None and len(self.ends) > 1:
            raise ValueError("'plus_minus' replaces min and max")
        kinds = {name: with_article(end.dimension) for name, end in self._written.items()}
        if len(set(kinds.values())) > 1:
            raise ValueError(f"min is {kinds['min']}, max {kinds['max']}")
        ends = self.min, self.max
        if all(isinstance(end, Quantity) for end in ends) and self.min.si >= self.max.si:  # type: ignore[union-attr]  # quantities
            raise ValueError(f"min ({self.min}) must be below max ({self.max})")
        if self.plus_minus is not None:
            self._require_difference()
        if self.mean and (self.worst or self.each is not None):
            raise ValueError("'mean' cannot be combined; 'each' and 'worst' can")
        if self.mean and self.follows:
            raise ValueError("a mean has no limit that follows a coordinate")
        return self

    def _require_difference(self) -> None:
        written = self._written["plus_minus"]
        if written.unit.offset:
            raise ValueError(f"got '{written}', a temperature; write a difference in K")
        if written.si < 0 or (written.si == 0 and not self.follows):
            raise ValueError(f"got '{written}', expected more than 0")

    @property
    def ends(self) -> dict[str, Quantity | Line | Table]:
        """The limits by their keys."""
        ends = {"min": self.min, "max": self.max, "plus_minus": self.plus_minus}
        return {name: end for name, end in ends.items() if end is not None}

    @property
    def _written(self) -> dict[str, Quantity]:
        return {
            name: end if isinstance(end, Quantity) else end.written
            for name, end in self.ends.items()
        }

    @property
    def follows(self) -> set[str]:
        """The coordinates that it follows."""
        return {end.over for end in self.ends.values() if not isinstance(end, Quantity)}

    def of_result(self) -> Iterator[tuple[tuple[str | int, ...], Quantity]]:
        """Yield each value of the result that it names, and where it stands in the limit."""
        for name, end in self.ends.items():
            if isinstance(end, Quantity):
                yield (name,), end
            else:
                for place, value in end.of_result():
                    yield (name, *place), value

    def of_coordinates(self) -> Iterator[tuple[tuple[str | int, ...], str, Quantity]]:
        """Yield each value of a coordinate: where it stands in the limit, of which one, and it."""
        for key, places in (("where", self.where), ("except", self.except_)):
            for name, values in places.items():
                yield from (((key, name), name, v) for v in values if isinstance(v, Quantity))
        for key, end in self.ends.items():
            if not isinstance(end, Quantity):
                place, value = end.of_coordinate()
                yield (key, *place), end.over, value

    @property
    def highest(self) -> Quantity | None:
        """The upper limit, where it is one quantity."""
        return self.max if isinstance(self.max, Quantity) else None

    @property
    def dimension(self) -> str:
        """The kind of quantity that it limits."""
        return self.written.dimension

    @property
    def written(self) -> Quantity:
        """One of the limits as the procedure writes it."""
        return next(iter(self._written.values()))

    def is_of(self, coordinates: Mapping[str, CoordinateValue]) -> bool:
        """Say whether it limits results at that place."""
        excepted = self.except_ and is_in(self.except_, coordinates)
        return is_in(self.where, coordinates) and not excepted

    def objection_to(
        self, result: ResultDefinition, analyses: Sequence[str] | None = None
    ) -> tuple[str, str]:
        """Return why it is for another measurand than that of a result, and a hint; '' if not.

        `analyses` are those of the procedure; if None, the hint is by all that are installed.
        """
        if self.measurand is None:
            if result.measurand is None:
                return "", ""
            message = f"'{self.of}' is the {result.measurand}, and the key 'measurand' is missing"
            models = measurand_models({} if analyses is None else {ASKED: analyses})
            keys = " or ".join(
                ", ".join(key for key, field in model.model_fields.items() if field.is_required())
                for model in models
            )
            return message, f"state it by the keys {keys}" if keys else ""
        if result.measurand is None:
            message = f"'{self.of}' does not say whether it is the {self.measurand}"
            return message, "leave 'measurand' out"
        hint = "a limit applies only to results of the same measurand"
        return self.measurand.objection(result.measurand), hint

    def misfits(self, result: ResultDefinition) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
        """Yield each value that cannot be one of that result: its place, a message and a hint."""
        for place, value in self.of_result():
            if problem := misfit(value, result):
                yield place, *problem
        if self.plus_minus is not None and unit(result.unit).offset:
            message = f"'{result.name}' is a temperature in {result.unit}, and no difference"
            yield ("plus_minus",), message, "write min and max"

    def limits_at(self, coordinates: Mapping[str, CoordinateValue], symbol: str) -> Limits:
        """Return the limits at a place as numbers in a unit of the same kind.

        Raises DataError where a limit that follows a coordinate has none there.
        """
        if self.plus_minus is not None:
            half = _number(self.plus_minus, coordinates, symbol, is_difference=True)
            if half <= 0:  # a share of a coordinate that is 0 there, or a line that has fallen
                at = ", ".join(f"{name} = {coordinates[name]}" for name in sorted(self.follows))
                raise DataError(f"the limit at {at} is {half:g} {symbol}, which is not above 0")
            return Limits.between(-half, half, symbol)
        low, high = (
            None if end is None else _number(end, coordinates, symbol)
            for end in (self.min, self.max)
        )
        if low is not None and high is not None and low >= high:
            raise DataError(f"the lower limit, {low:g} {symbol}, is not below the upper one there")
        return Limits.between(low, high, symbol)

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it, with units; read back, it is the same."""
        content: dict[str, object] = {"of": self.of}
        for name, places in (("where", self.where), ("except", self.except_)):
            if places:
                texts = {at: [str(value) for value in values] for at, values in places.items()}
                content[name] = {at: t if len(t) > 1 else t[0] for at, t in texts.items()}
        if self.each is not None:
            content["each"] = self.each
        content |= {name: True for name in ("mean", "worst") if getattr(self, name)}
        content |= {
            name: str(end) if isinstance(end, Quantity) else end.as_written()
            for name, end in self.ends.items()
        }
        if self.measurand is not None:
            content["measurand"] = self.measurand.as_written()
        return content | {"source": self.source}

    @property
    def scope(self) -> str:
        """What it limits, in words that are equal for equal scopes."""
        where = places_text(self.where)
        without = places_text(self.except_)
        how = "mean" if self.mean else "each" if self.each or not self.worst else "worst"
        return (
            f"{self.of}{f' at {where}' if where else ''}"
            f"{f' except at {without}' if without else ''} ({how})"
        )


def misfit(value: Quantity, result: ResultDefinition) -> tuple[str, str] | None:
    """Return why a value cannot be one of a result, and a hint; None if it can.

    A result in K may be a difference, of which 0.7 °C would be 273.85 K.
    """
    unit_ = unit(result.unit)
    if value.dimension != unit_.dimension:
        kinds = with_article(value.dimension), with_article(unit_.dimension)
        message = f"'{value}' is {kinds[0]}; {result.name} is {kinds[1]}, in {result.unit}"
        return message, f"write it in {result.unit}"
    if value.unit.offset and not unit_.offset:
        message = (
            f"'{value}' is a temperature, and {result.name}, in {result.unit}, may be a difference"
        )
        amounts = (value.number * value.unit.factor / unit_.factor, value.si / unit_.factor)
        of_difference, of_value = (f"'{amount:.6g} {result.unit}'" for amount in amounts)
        return message, f"write {of_difference} for a difference, else {of_value}"
    return None


def _require_json(measurand: LimitedMeasurand) -> None:
    """Raise PluginError for a measurand that `result.json` cannot have: the run would not end."""
    try:
        json.dumps(measurand.document(), allow_nan=False)
    except (TypeError, ValueError) as error:
        name = type(measurand).__name__
        raise PluginError(
            f"the measurand of a limit, {name}, gave a document that is no JSON: {error}",
            hint="its author must fix it: plain values, with a description as 'text'",
        ) from error


def _number(
    end: Quantity | Line | Table,
    coordinates: Mapping[str, CoordinateValue],
    symbol: str,
    *,
    is_difference: bool = False,
) -> float:
    unit_ = unit(symbol)
    if isinstance(end, Quantity):
        if end.unit.symbol == symbol:
            return end.number
        si = end.si
    else:
        si = end.si_at(coordinates)
    offset = 0.0 if is_difference else unit_.offset
    # 15 digits, without the rounding of the conversion: a limit reads as it was written.
    return float(f"{(si - offset) / unit_.factor:.15g}")
