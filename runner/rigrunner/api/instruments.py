"""What the register of a station says of an instrument, whatever it measures (all SI)."""

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

from rigrunner.api import calibration_curve
from rigrunner.api.accuracy import MOST_OF_SOURCE, Accuracy, ErrorLimit, StatedAccuracy
from rigrunner.api.calibration import CalibratedRange, CalibrationConditions, CalibrationPoint
from rigrunner.api.errors import did_you_mean
from rigrunner.api.filters import AnyFilter
from rigrunner.api.member import Member
from rigrunner.api.quantity import Quantity
from rigrunner.api.settings import AnyQuantity, IsoDate, ListOf, PlainText, Settings
from rigrunner.api.units import QuantityError, kinds, si_symbol, with_article

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from numpy import float64
    from numpy.typing import NDArray

    from rigrunner.api.accuracy import ReadingError

STORED = "stored"
"""The key in the context of validation that says that an entry is of a run made before."""
LEAST_POINTS = 2
"""Of a table that readings are corrected by."""
TORQUE = "torque"
ZEROED = (TORQUE, "force")
"""Quantities whose calibration begins with a zero that is taken off (DIN 51309, ISO 376)."""


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
        raise QuantityError("what a certificate says stands in keys of its own", hint=hint)
    return value


class Instrument(Settings):
    """The register's entry for an instrument of any quantity.

    A torque transducer is one whose quantity is torque, in N·m.
    """

    channel: Annotated[Member, Field(description="role.channel, such as tester.torque")]
    quantity: Annotated[
        str, AfterValidator(_kind), Field(alias="measures", json_schema_extra=_name_quantities)
    ] = TORQUE
    """The quantity, such as force, angle or temperature."""
    id: PlainText = ""
    """The laboratory's own number of it."""
    maker: PlainText = ""
    """Who made it."""
    type: PlainText = ""
    """The maker's designation."""
    serial: PlainText
    """Its serial number."""
    certificate: PlainText = ""
    """The number of its calibration certificate."""
    laboratory: PlainText = ""
    """Who calibrated it."""
    calibrated: IsoDate | None = None
    """When it was calibrated."""
    due: IsoDate | None = None
    """When it is to be calibrated again; it may be used on that day."""
    calibration: Annotated[
        Literal["simulated", "recorded", "trial"] | None, BeforeValidator(_no_mapping)
    ] = None
    """Why there is nothing to calibrate: the device is `simulated`, its values were `recorded`
    before and are only read from a file, or the set-up is a `trial`: of what that measures nothing
    can be certified. Left out: the instrument is calibrated."""
    full_scale_: Annotated[AnyQuantity | None, Field(alias="full_scale")] = None
    """Its nominal value; left out, the end of the range."""
    range_: Annotated[CalibratedRange | None, Field(alias="range")] = None
    """Between which values the calibration holds."""
    points: ListOf[CalibrationPoint] = ()
    """The table of the certificate."""
    interpolation: Literal["linear", "cubic"] | None = None
    """Corrects each reading by the calibration `points`: on straight lines between them, or by a
    cubic through zero that is fitted to them. Left out: readings are not corrected."""
    conditions: CalibrationConditions | None = None
    """The ambient conditions for which the calibration is valid."""
    accuracy_: Annotated[StatedAccuracy | None, Field(alias="accuracy")] = None
    """What its readings may be off by: in one figure, or error by error."""
    low_pass: AnyFilter | None = None
    """The filter before the converter. Methods that undo it need it."""

    @field_validator("full_scale_", "range_", "points")
    @classmethod
    def _of_its_quantity(cls, value: Any, info: ValidationInfo) -> Any:
        """Refuse values of another quantity; one that is wrong itself is reported already."""
        wanted = info.data.get("quantity")
        written = [value] if isinstance(value, Quantity) else []
        written += [value.max] if isinstance(value, CalibratedRange) else []
        written += [each.applied for each in value] if isinstance(value, tuple) else []
        for each in written:
            if wanted is not None and each.dimension != wanted:
                got = with_article(each.dimension)
                raise ValueError(f"got '{each}', {got}, expected {with_article(wanted)}")
        if isinstance(value, Quantity) and value.si <= 0:
            raise ValueError(f"got '{value}', expected more than 0")
        return value

    @field_validator("accuracy_")
    @classmethod
    def _limits_of_its_quantity(
        cls, value: Accuracy | None, info: ValidationInfo
    ) -> Accuracy | None:
        """Refuse limits of error of another quantity; a run of before may have them."""
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
        """Yield all that is wrong with how its parts fit together."""
        if self.calibrated and self.due and self.calibrated > self.due:
            yield f"calibrated ({self.calibrated}) must not be after due ({self.due})"
        if self.quantity == TORQUE and self.accuracy_ is None and not self.points:
            yield "the key 'accuracy' is missing, or calibration 'points'"
        if math.isnan(self.full_scale):
            if self.quantity == TORQUE:
                yield "the key 'full_scale' is missing, or a 'range'"
            shares = {} if stored or not self.accuracy_ else self.accuracy_.shares_of_full_scale()
            for name, limit in shares.items():
                yield f"accuracy.{name} is '{limit}', and no 'full_scale' or 'range' says of what"
        if self.interpolation is not None:
            yield from self._objections_to_points()

    def _objections_to_points(self) -> Iterator[str]:
        if self.interpolation == "cubic" and self.quantity not in ZEROED:
            yield f"a cubic goes through zero: of {with_article(self.quantity)} use 'linear'"
            return
        if len(self.points) < LEAST_POINTS:
            yield f"interpolation needs {LEAST_POINTS} points or more; there are {len(self.points)}"
        pairs = sorted((point.applied.si, point.indicated.si) for point in self.points)
        for (applied, indicated), (next_applied, next_indicated) in pairwise(pairs):
            if next_applied <= applied or next_indicated <= indicated:
                at = f"{applied:g} {si_symbol(self.quantity)}"
                yield f"points: indicated must rise with applied, and does not at {at}"
                return
        if self.interpolation == "cubic":
            yield from self._objections_to_cubic()

    def _objections_to_cubic(self) -> Iterator[str]:
        count = calibration_curve.too_few_for_cubic(self._known)
        if count is not None:
            least = calibration_curve.DEGREE + 1
            yield f"a cubic needs {least} points in each direction that has some; there are {count}"
            return
        for (low, low_off), (high, high_off) in pairwise(self.deviations):
            if high - high_off <= low - low_off:
                at = f"{low:.3g} {si_symbol(self.quantity)}"
                yield f"points: the cubic does not rise with applied near {at}"
                return

    @property
    def name(self) -> str:
        """The laboratory's number, or else the serial number."""
        return self.id or self.serial

    @property
    def full_scale(self) -> float:
        """The nominal value in SI: as entered, or the end of the range; nan: neither is stated."""
        if self.full_scale_ is not None:
            return self.full_scale_.si
        return self._entered_range[1] if self._entered_range else math.nan

    @property
    def calibrated_range(self) -> tuple[float, float] | None:
        """Lowest and highest value, in SI, for which the calibration holds; None: not stated.

        As entered, or else as far as the calibration points reach, zero included, or else full
        scale. A torque transducer turns both ways alike where `range` has no `min`.
        """
        found = self._entered_range
        if found is None and not math.isnan(self.full_scale):
            found = -math.inf, self.full_scale
        if found is None:
            return None
        lowest, highest = found
        both_ways = self.quantity == TORQUE and math.isinf(lowest)
        return (-highest if both_ways else lowest), highest

    def beyond_range(self, lowest: float, highest: float, unit: str) -> str:
        """Return how far values in an SI unit went beyond that range, in words; '' if they did not.

        `unit` is shown.
        """
        bounds = self.calibrated_range
        if bounds is None or bounds[0] <= lowest <= highest <= bounds[1]:
            return ""
        is_above = highest - bounds[1] >= bounds[0] - lowest
        worst, bound = (highest, bounds[1]) if is_above else (lowest, bounds[0])
        share = f" ({100 * worst / bound:.0f} %)" if bound else ""
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
        return min(0.0, *applied), max(0.0, *applied)

    @property
    def accuracy(self) -> Accuracy | None:
        """What its readings may be off by: as stated, or else what the calibration points allow.

        The points stand for the figure over all where none is stated, nor gain, offset or
        nonlinearity. Where readings are not corrected by the points, that is the greatest of
        |deviation| + U among them, the same over the whole range (after GUM F.2.4.5). Where they
        are, it is the greatest U, and the most that a point is off the straight line between its
        neighbours, or off the cubic.
        """
        stated = self.accuracy_
        if not self.points or (stated is not None and stated.has_calibration):
            return stated
        corrected = self.interpolation is not None
        limits = (
            (0 if corrected else abs(p.deviation)) + p.k * p.standard_uncertainty
            for p in self.points
        )
        limit = max(limits) + (self._off_the_curve if corrected else 0.0)
        overall = ErrorLimit(
            limit=f"{limit!r} {si_symbol(self.quantity)}", source=self.certificate[:MOST_OF_SOURCE]
        )
        return (stated or Accuracy()).model_copy(update={"overall": overall})

    def half_width(self, name: str, value: float | None = None) -> float:
        """Return the limit of one error at a value, or else at full scale, in the SI unit.

        0 where nothing is stated. A gain is a share; of a resolution it is half of the step.
        """
        known, at = self.accuracy, self.full_scale if value is None else value
        return known.half_width(name, at, self.full_scale) if known else 0.0

    def limit_of_error(self, value: float) -> float | None:
        """Return what it may be off by at a value, both in the SI unit; None if nothing says it."""
        known = self.accuracy
        limit = known.limit_of_error(value, self.full_scale) if known else math.nan
        return None if math.isnan(limit) else limit

    def reading_errors(self, value: float, *, zeroed: bool = False) -> tuple[ReadingError, ...]:
        """Return what a reading of a value, in the SI unit, may be off by, each error by itself.

        `zeroed`: a zero was taken off, and with it the offset. Empty where nothing is known.
        """
        known = self.accuracy
        found = known.errors(self.channel, value, self.full_scale) if known else ()
        return tuple(each for each in found if not (zeroed and each.acts == "offset"))

    @property
    def deviations(self) -> tuple[tuple[float, float], ...]:
        """What the points show: ascending indicated values, each with indicated less applied, SI.

        Of torque and force, of which a zero is taken off first, there is none at zero, and points
        of one direction stand for both.
        """
        if self.interpolation == "cubic":
            return calibration_curve.cubic(self._known)
        return calibration_curve.linear(self._known, through_zero=self.quantity in ZEROED)

    def corrected(self, values: NDArray[float64], zero: float = 0.0) -> NDArray[float64]:
        """Return indicated values less a zero reading, less what they deviate, shape (n,), in SI.

        Between the values of `deviations` on straight lines; beyond the last it stays what it is
        there. Without `interpolation` only the zero is taken off.
        """
        if self.interpolation is None:
            return values - zero
        import numpy as np  # noqa: PLC0415  (a register is read without it)

        at, off = zip(*self.deviations, strict=True)
        if self.quantity in ZEROED:
            less_zero = values - zero
            return np.asarray(less_zero - np.interp(less_zero, at, off))
        true_zero = zero - np.interp(zero, at, off) if zero else 0.0
        return np.asarray(values - np.interp(values, at, off) - true_zero)

    @property
    def _known(self) -> dict[float, float]:
        known = {point.indicated.si: point.deviation for point in self.points}
        if self.quantity in ZEROED and (min(known) >= 0 or max(known) <= 0):
            known = {-indicated: -deviation for indicated, deviation in known.items()} | known
        return known

    @property
    def _off_the_curve(self) -> float:
        if self.interpolation == "cubic":
            return calibration_curve.off_cubic(self._known)
        return calibration_curve.off_linear(self.deviations)


def is_stored(info: ValidationInfo) -> bool:
    """Say whether an entry is of a run made before, by the context of its validation."""
    return info.context is not None and bool(info.context.get(STORED))


def torque_instruments(register: Iterable[Instrument]) -> dict[str, Instrument]:
    """Return the torque transducers of a register by channel."""
    return {each.channel: each for each in register if each.quantity == TORQUE}


def __getattr__(name: str) -> Any:
    """Give the names of version 0.1.0, with a warning."""
    if name in {"TorqueInstrument", "OtherInstrument"}:
        message = f"rigrunner.api.instruments.{name} is Instrument now; the name goes with 0.3"
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        return Instrument
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
