"""Entries of the station's register of instruments, for any quantity (all SI)."""

from __future__ import annotations

import math
import warnings
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from rigrunner.api.accuracy import MOST_OF_SOURCE, Accuracy, ErrorLimit, StatedAccuracy
from rigrunner.api.calibration import CalibratedRange, CalibrationConditions, CalibrationPoint
from rigrunner.api.calibration_curve import (
    DEGREE,
    cubic,
    linear,
    off_cubic,
    off_linear,
    too_few_for_cubic,
)
from rigrunner.api.errors import did_you_mean
from rigrunner.api.filters import AnyFilter
from rigrunner.api.member import Member
from rigrunner.api.quantity import Quantity
from rigrunner.api.settings import AnyQuantity, IsoDate, ListOf, PlainText, Settings
from rigrunner.api.unit_tables import LEVELS
from rigrunner.api.units import QuantityError, kinds, si_symbol, with_article
from rigrunner.moved import moved

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy import float64
    from numpy.typing import NDArray

    from rigrunner.api.accuracy import ReadingError

STORED = "stored"
"""Key in the validation context that marks an entry of a stored run."""
LEAST_POINTS = 2
"""Least number of points of a correction table."""
TORQUE = "torque"
DEFAULT_QUANTITY = TORQUE
"""The quantity of an entry without `measures`, as in stations of 0.1.0."""
ZEROED = (TORQUE, "force")
"""Quantities that are calibrated relative to a zero reading (DIN 51309, ISO 376)."""


def _name_quantities(schema: dict[str, Any]) -> None:
    schema["enum"] = list(kinds())


def _kind(text: str) -> str:
    if text not in kinds():
        hint = did_you_mean(text, kinds(), f"expected one of: {', '.join(kinds())}")
        raise QuantityError(f"'{text[:40]}' is not a quantity", hint=hint)
    return text


def _no_mapping(value: object) -> object:
    if isinstance(value, dict):
        hint = (
            "leave 'calibration' out, and write certificate, laboratory, calibrated and due"
            " beside 'serial'"
        )
        raise QuantityError("a certificate has keys of its own", hint=hint)
    return value


class Instrument(Settings):
    """An entry of the register, for an instrument of any quantity.

    A torque transducer has the quantity torque, in N·m.
    """

    channel: Annotated[Member, Field(description="role.channel, such as tester.torque")]
    # Before all that has its unit: a validator sees only the fields above its own.
    quantity: Annotated[
        str, AfterValidator(_kind), Field(alias="measures", json_schema_extra=_name_quantities)
    ] = DEFAULT_QUANTITY
    """The quantity, such as force, angle or temperature."""
    id: PlainText = ""
    """Inventory number of the laboratory."""
    maker: PlainText = ""
    """The manufacturer."""
    type: PlainText = ""
    """Type designation of the manufacturer."""
    serial: PlainText
    """Its serial number."""
    certificate: PlainText = ""
    """Number of the calibration certificate."""
    laboratory: PlainText = ""
    """The calibration laboratory."""
    calibrated: IsoDate | None = None
    """Date of calibration."""
    due: IsoDate | None = None
    """Date on which the calibration expires; the last day of use."""
    calibration: Annotated[
        Literal["simulated", "recorded", "trial"] | None, BeforeValidator(_no_mapping)
    ] = None
    """Why there is no calibration: the device is `simulated`, its values were `recorded` before and
    are read from a file, or the set-up is a `trial`, whose results cannot be certified. If
    omitted, the instrument is calibrated."""
    full_scale_: Annotated[AnyQuantity | None, Field(alias="full_scale")] = None
    """Nominal value; if omitted, the end of the range."""
    range_: Annotated[CalibratedRange | None, Field(alias="range")] = None
    """Range for which the calibration is valid."""
    points: ListOf[CalibrationPoint] = ()
    """Table of the calibration certificate."""
    interpolation: Literal["linear", "cubic"] | None = None
    """Corrects readings by the calibration `points`: by straight lines between them, or by a cubic
    through zero fitted to them. If omitted, readings are not corrected."""
    conditions: CalibrationConditions | None = None
    """Ambient conditions for which the calibration is valid."""
    accuracy_: Annotated[StatedAccuracy | None, Field(alias="accuracy")] = None
    """Accuracy of the readings: one limit for all errors, or one for each."""
    low_pass: AnyFilter | None = None
    """The filter before the converter; required by methods that undo it."""

    @field_validator("full_scale_", "range_", "points")
    @classmethod
    def _of_its_quantity(cls, value: Any, info: ValidationInfo) -> Any:
        """Refuse values of other quantities; invalid values have been reported already."""
        kind = info.data.get("quantity")
        # One value of a range or a point is enough: they were checked to be of one kind.
        quantities = [value] if isinstance(value, Quantity) else []
        quantities += [value.max] if isinstance(value, CalibratedRange) else []
        quantities += [point.applied for point in value] if isinstance(value, tuple) else []
        for quantity in quantities:
            if kind is not None and quantity.dimension != kind:
                got = with_article(quantity.dimension)
                raise ValueError(f"got '{quantity}', {got}, expected {with_article(kind)}")
        if isinstance(value, Quantity) and value.si <= 0:
            raise ValueError(f"got '{value}', expected more than 0")
        return value

    @field_validator("accuracy_")
    @classmethod
    def _limits_of_its_quantity(
        cls, value: Accuracy | None, info: ValidationInfo
    ) -> Accuracy | None:
        """Refuse limits of error of other quantities; stored runs may have them."""
        quantity = info.data.get("quantity")
        if value is None or quantity is None:
            return value
        if not value.limits:
            raise ValueError(f"got nothing, expected one of: {', '.join(Accuracy.model_fields)}")
        objections = [] if is_stored(info) else list(value.objections(quantity))
        if objections:
            raise ValueError("; ".join(objections))
        return value

    @model_validator(mode="after")
    def _parts_fit_together(self, info: ValidationInfo) -> Self:
        objections = list(self._objections(stored=is_stored(info)))
        if objections:
            raise ValueError("; ".join(objections))
        return self

    def _objections(self, *, stored: bool) -> Iterator[str]:
        """Yield every inconsistency of its fields."""
        if self.calibrated and self.due and self.calibrated > self.due:
            yield f"calibrated ({self.calibrated}) must not be after due ({self.due})"
        if self.quantity == TORQUE and self.accuracy_ is None and not self.points:
            yield "the key 'accuracy' is missing, or calibration 'points'"
        if math.isnan(self.full_scale):
            if self.quantity == TORQUE:
                yield "the key 'full_scale' is missing, or a 'range'"
            shares = {} if stored or not self.accuracy_ else self.accuracy_.shares_of_full_scale()
            for name, limit in shares.items():
                yield f"accuracy.{name} is '{limit}', but 'full_scale' and 'range' are missing"
        if self.interpolation is not None:
            yield from self._objections_to_points()
            if not stored:
                yield from self._objections_to_accuracy()

    def _objections_to_accuracy(self) -> Iterator[str]:
        """Yield why a stated accuracy cannot hold for readings that the points correct.

        The points give all errors that the correction leaves. A limit of the same errors beside
        them would count these twice, or lose U of the points (GUM 4.3.10).
        """
        limits = self.accuracy_.limits if self.accuracy_ else {}
        for name in ("gain", "offset", "nonlinearity"):
            if name in limits:
                yield (
                    f"accuracy.{name}: the 'points' that correct the readings give what is left of"
                    " it, with their U: leave it out, or 'interpolation'"
                )
        if "overall" in limits:
            for point in self.points:
                width = self.half_width("overall", point.indicated.si)
                if width < point.half_width:
                    least = "U" if point.k >= math.sqrt(3) else "√3 U/k"
                    limit = limits["overall"].limit
                    yield f"accuracy '{limit}' is less than {least} at {point.applied}"
                    return

    def _objections_to_points(self) -> Iterator[str]:
        if self.interpolation == "cubic" and self.quantity not in ZEROED:
            yield f"a cubic goes through zero: for {with_article(self.quantity)} use 'linear'"
            return
        if len(self.points) < LEAST_POINTS:
            yield f"interpolation needs {LEAST_POINTS} points or more, got {len(self.points)}"
        pairs = sorted((point.applied.si, point.indicated.si) for point in self.points)
        for (applied, indicated), (next_applied, next_indicated) in pairwise(pairs):
            # Else one indication would stand for two values, and could not be corrected.
            if next_applied <= applied or next_indicated <= indicated:
                at = f"{applied:g} {si_symbol(self.quantity)}"
                yield f"points: indicated must rise with applied, and does not at {at}"
                return
        if self.interpolation == "cubic":
            yield from self._objections_to_cubic()

    def _objections_to_cubic(self) -> Iterator[str]:
        count = too_few_for_cubic(self._point_deviations)
        if count is not None:
            least = DEGREE + 1
            yield f"a cubic needs {least} points in each direction that has any, got {count}"
            return
        for (low, low_off), (high, high_off) in pairwise(self.deviations):
            # Indicated less deviation is the applied value.
            if high - high_off <= low - low_off:
                at = f"{low:.3g} {si_symbol(self.quantity)}"
                yield f"points: the cubic does not rise with applied near {at}"
                return

    @property
    def name(self) -> str:
        """The inventory number, or else the serial number."""
        return self.id or self.serial

    @property
    def full_scale(self) -> float:
        """The nominal value in SI: as stated, or the end of the range; nan if neither is stated."""
        if self.full_scale_ is not None:
            return self.full_scale_.si
        return self._entered_range[1] if self._entered_range else math.nan

    @property
    def calibrated_range(self) -> tuple[float, float] | None:
        """Lowest and highest value, in SI, of the calibration; None if not stated.

        As stated, or else the span of the calibration points, with zero where this is nothing, or
        else full scale. For a torque transducer a `range` without `min` is symmetrical.
        """
        bounds = self._entered_range
        if bounds is None and not math.isnan(self.full_scale):
            bounds = -math.inf, self.full_scale
        if bounds is None:
            return None
        lowest, highest = bounds
        is_symmetrical = self.quantity == TORQUE and math.isinf(lowest)
        return (-highest if is_symmetrical else lowest), highest

    def beyond_range(self, lowest: float, highest: float, unit: str) -> str:
        """Return, as text, by how much values in an SI unit exceed that range; '' for not at all.

        `unit` is the unit of the text. Of a range that begins or ends at zero, values about zero
        within the limit of error are no excess.
        """
        bounds = self.calibrated_range
        if bounds is None:
            return ""
        at_zero = self.limit_of_error(0.0) or 0.0
        low, high = bounds[0] or -at_zero, bounds[1] or at_zero
        if low <= lowest <= highest <= high:
            return ""
        is_above = highest - bounds[1] >= bounds[0] - lowest
        worst, bound = (highest, bounds[1]) if is_above else (lowest, bounds[0])
        share = f" ({100 * worst / bound:.0f} %)" if bound else ""
        if abs(worst) < abs(bound) or not (is_above or bound):  # below where it begins
            return f"{worst:.4g} {unit} was recorded, the calibration holds from {bound:.4g} {unit}"
        holds = f"the calibration holds up to {bound:.4g} {unit}"
        return f"{worst:.4g} {unit} was recorded, {holds}{share}"

    @property
    def _entered_range(self) -> tuple[float, float] | None:
        if self.range_ is not None:
            lowest = self.range_.min
            return (-math.inf if lowest is None else lowest.si), self.range_.max.si
        if not self.points:
            return None
        applied = [point.applied.si for point in self.points]
        # 0 K, 0 dBm or pH 0 is not nothing: a calibration from 10 °C does not include it.
        if self.quantity != "temperature" and self.quantity not in LEVELS:
            applied.append(0.0)
        return min(applied), max(applied)

    @property
    def accuracy(self) -> Accuracy | None:
        """The accuracy of the readings: as stated, or else from the calibration points.

        The points take the place of the overall limit if neither this nor gain, offset or
        nonlinearity is stated; with `interpolation` only an overall limit may be stated beside
        them, no less than U. Without correction it is the greatest deviation + U of the points,
        for the whole range (after GUM F.2.4.5). With correction it is the greatest U, and the
        greatest distance of a point from the line between its neighbours, or from the cubic. For
        a U with k below √3 it is √3 U/k: the limit counts as a rectangle.
        """
        accuracy = self.accuracy_
        if not self.points or (accuracy is not None and accuracy.has_calibration):
            return accuracy
        corrected = self.interpolation is not None
        limits = ((0 if corrected else abs(p.deviation)) + p.half_width for p in self.points)
        limit = max(limits) + (self._off_the_curve if corrected else 0.0)
        overall = ErrorLimit(
            limit=f"{limit!r} {si_symbol(self.quantity)}", source=self.certificate[:MOST_OF_SOURCE]
        )
        return (accuracy or Accuracy()).model_copy(update={"overall": overall})

    def half_width(self, name: str, value: float | None = None) -> float:
        """Return the limit of one error at a value, or else at full scale, in the SI unit.

        0 if not stated. A gain is relative; a resolution counts half its step.
        """
        accuracy, at = self.accuracy, self.full_scale if value is None else value
        return accuracy.half_width(name, at, self.full_scale) if accuracy else 0.0

    def limit_of_error(self, value: float) -> float | None:
        """Return the limit of error at a value, both in the SI unit; None if unknown."""
        accuracy = self.accuracy
        limit = accuracy.limit_of_error(value, self.full_scale) if accuracy else math.nan
        return None if math.isnan(limit) else limit

    def reading_errors(self, value: float, *, zeroed: bool = False) -> tuple[ReadingError, ...]:
        """Return the errors of a reading at a value, in the SI unit.

        `zeroed`: a zero reading is subtracted, which removes the offset. Empty if unknown.
        """
        accuracy = self.accuracy
        errors = accuracy.errors(self.channel, value, self.full_scale) if accuracy else ()
        return tuple(error for error in errors if not (zeroed and error.acts == "offset"))

    @property
    def deviations(self) -> tuple[tuple[float, float], ...]:
        """Deviations by ascending indicated value: indicated minus applied, in SI.

        Torque and force, which are zeroed, have none at zero; points of one direction are used for
        both.
        """
        if self.interpolation == "cubic":
            return cubic(self._point_deviations)
        return linear(self._point_deviations, through_zero=self.quantity in ZEROED)

    def corrected(self, values: NDArray[float64], zero: float | None = None) -> NDArray[float64]:
        """Return indicated values minus zero reading and deviations, shape (n,), in SI.

        Deviations are interpolated linearly, and constant beyond the last. Without `interpolation`
        only the zero reading is subtracted; `zero` is None if there is none.
        """
        if self.interpolation is None:
            return values - (zero or 0.0)
        import numpy as np  # noqa: PLC0415  (a register is read without it)

        indicated, deviations = zip(*self.deviations, strict=True)
        if self.quantity in ZEROED:
            less_zero = values - (zero or 0.0)
            return np.asarray(less_zero - np.interp(less_zero, indicated, deviations))
        true_zero = 0.0 if zero is None else zero - np.interp(zero, indicated, deviations)
        return np.asarray(values - np.interp(values, indicated, deviations) - true_zero)

    @property
    def _point_deviations(self) -> dict[float, float]:
        table = {point.indicated.si: point.deviation for point in self.points}
        if self.quantity in ZEROED and (min(table) >= 0 or max(table) <= 0):
            table = {-indicated: -deviation for indicated, deviation in table.items()} | table
        return table

    @property
    def _off_the_curve(self) -> float:
        if self.interpolation == "cubic":
            return off_cubic(self._point_deviations)
        return off_linear(self.deviations)


def is_stored(info: ValidationInfo) -> bool:
    """Return whether an entry belongs to a stored run, by the validation context."""
    return info.context is not None and bool(info.context.get(STORED))


def __getattr__(name: str) -> Any:
    """Return names of version 0.1.0, with a warning."""
    if name in {"TorqueInstrument", "OtherInstrument"}:
        message = (
            f"rigrunner.api.instruments.{name} is now Instrument; the old name will be"
            " removed in 0.3"
        )
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        return Instrument
    return moved(__name__, name)
