"""What the register says of an instrument, and what the station says of the rig (all SI)."""

from __future__ import annotations

import difflib
import math
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    model_validator,
)

from rigrunner.api import calibration_curve
from rigrunner.api.accuracy import OVER_U, AccuracyInParts, AnyAccuracy, misread
from rigrunner.api.calibration import (
    CalibratedRange,
    CalibrationConditions,
    CalibrationPoint,
    StatedTorqueAccuracy,
    TorqueAccuracy,
    limit_of_error,
)
from rigrunner.api.filters import AnyFilter
from rigrunner.api.member import Member
from rigrunner.api.reading_errors import Acts, ReadingError
from rigrunner.api.settings import (
    IsoDate,
    ListOf,
    PlainText,
    Settings,
    Torque,
)
from rigrunner.api.transducer import TransducerErrors
from rigrunner.api.units import QuantityError, kinds

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

STORED = "stored"
"""The key in the context of validation that says that an entry is of a run made before."""
LEAST_POINTS = 2
"""Of a table that readings are corrected by."""


def _other_quantities() -> list[str]:
    """Return the kinds of quantities but torque, with those that plugins have added by now."""
    return [kind for kind in kinds() if kind != "torque"]


def _name_quantities(schema: dict[str, Any]) -> None:
    schema["enum"] = _other_quantities()


def _dimension(text: str) -> str:
    if text not in _other_quantities():
        near = difflib.get_close_matches(text, kinds(), n=1)
        known = f"expected torque or one of: {', '.join(_other_quantities())}"
        hint = f"did you mean '{near[0]}'?" if near else known
        raise QuantityError(f"'{text[:40]}' is no quantity", hint=hint)
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
    """What the register has of any instrument."""

    channel: Annotated[Member, Field(description="role.channel, such as tester.torque")]
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
    range_: Annotated[CalibratedRange | None, Field(alias="range")] = None
    """Between which values the calibration holds."""
    points: ListOf[CalibrationPoint] = ()
    """The table of the certificate."""
    conditions: CalibrationConditions | None = None
    """In which surroundings the calibration holds."""

    @property
    def quantity(self) -> str:
        """The dimension of what it measures, such as 'torque'."""
        raise NotImplementedError

    def reading_errors(self, value: float, *, zeroed: bool = False) -> tuple[ReadingError, ...]:
        """Return what a reading of a value, in the SI unit, may be off by, each error by itself.

        `zeroed`: a zero was taken off, and with it the offset. Empty where nothing is known.
        """
        raise NotImplementedError

    @property
    def name(self) -> str:
        """The laboratory's number, or else the serial number."""
        return self.id or self.serial

    @property
    def calibrated_range(self) -> tuple[float, float] | None:
        """Lowest and highest value, in SI, for which the calibration holds; None: not stated.

        As entered, or else as far as the calibration points reach, zero included.
        """
        if self.range_ is not None:
            lowest = self.range_.min
            return (-math.inf if lowest is None else lowest.si), self.range_.max.si
        if not self.points:
            return None
        applied = [point.applied.si for point in self.points]
        return min(0.0, *applied), max(0.0, *applied)

    @model_validator(mode="after")
    def _parts_fit_together(self, info: ValidationInfo) -> Self:
        stored = info.context is not None and info.context.get(STORED)
        objections = [*self._objections(), *(() if stored else self._misread_limits())]
        if objections:
            raise ValueError("; ".join(objections))
        return self

    def _misread_limits(self) -> Iterator[str]:
        """Yield limits of error of another quantity; a run of before may have them."""
        return iter(())

    def _objections(self) -> Iterator[str]:
        """Yield all that is wrong with how its parts fit together."""
        if self.calibrated and self.due and self.calibrated > self.due:
            yield f"calibrated ({self.calibrated}) must not be after due ({self.due})"
        written = [("range", self.range_.max)] if self.range_ else []
        written += [("points", point.applied) for point in self.points]
        for name, value in written:
            if value.dimension != self.quantity:
                yield f"{name} has '{value}', a {value.dimension}; measured is a {self.quantity}"


class TorqueInstrument(Instrument):
    """A torque transducer with its amplifier, with what the analysis needs to know of it."""

    measures: Literal["torque"] = "torque"
    """The quantity."""
    full_scale: Annotated[Torque, Field(gt=0)]
    """Its nominal torque."""
    accuracy_: Annotated[StatedTorqueAccuracy | None, Field(alias="accuracy")] = None
    """Its limits of error; needless where there are calibration points."""
    interpolation: Literal["linear", "cubic"] | None = None
    """Corrects each reading by the calibration `points`: on straight lines between them, or by a
    cubic through zero that is fitted to them. Left out: readings are not corrected."""
    errors: TransducerErrors | None = None
    """What its certificate or data sheet states besides, each with its source."""
    low_pass: AnyFilter | None = None
    """Methods that undo the filter need it."""

    def _objections(self) -> Iterator[str]:
        yield from super()._objections()
        if self.accuracy_ is None and not self.points:
            yield "the key 'accuracy' is missing, or calibration 'points'"
        if self.interpolation is not None:
            yield from self._objections_to_points()

    def _objections_to_points(self) -> Iterator[str]:
        if len(self.points) < LEAST_POINTS:
            yield f"interpolation needs {LEAST_POINTS} points or more; there are {len(self.points)}"
        pairs = sorted((point.applied.si, point.indicated.si) for point in self.points)
        for (applied, indicated), (next_applied, next_indicated) in pairwise(pairs):
            if next_applied <= applied or next_indicated <= indicated:
                yield f"points: indicated must rise with applied, and does not at {applied:g} N·m"
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
                yield f"points: the cubic does not rise with applied near {low:.3g} N·m"
                return

    @property
    def quantity(self) -> str:
        """Torque."""
        return self.measures

    @property
    def accuracy(self) -> TorqueAccuracy:
        """The limits of error: as stated, or else what the calibration points allow.

        Where readings are not corrected by the points, the limit is the greatest of |deviation| + U
        among them, the same over the whole range (after GUM F.2.4.5). Where they are, it is the
        greatest U, and the most that a point is off the straight line between its neighbours, or
        off the cubic.
        """
        if self.accuracy_ is not None:
            return self.accuracy_
        corrected = self.interpolation is not None
        limits = (
            (0 if corrected else abs(p.deviation)) + p.k * p.standard_uncertainty
            for p in self.points
        )
        between = self._off_the_curve if corrected else 0.0
        return TorqueAccuracy.in_one_figure((max(limits) + between) / self.full_scale)

    def reading_errors(self, value: float, *, zeroed: bool = False) -> tuple[ReadingError, ...]:
        """Return what a reading may be off by: the accuracy, and what `errors` states besides."""
        accuracy, whole = self.accuracy, self.full_scale
        split: tuple[tuple[str, Acts, float], ...] = (
            ("gain", "gain", accuracy.gain),
            ("offset", "offset", 0.0 if zeroed else accuracy.offset),
            ("drift", "each", accuracy.drift),
            ("nonlinearity", "each", accuracy.nonlinearity * whole),
        )
        in_one = accuracy.of_full_scale * whole
        found = [
            ReadingError(f"{name} of {self.channel}", acts, width / OVER_U["rectangular"])
            for name, acts, width in ((("reading", "each", in_one),) if in_one else split)
        ]
        stated = self.errors.reading_errors(self.channel, value, whole) if self.errors else ()
        return (*found, *stated)

    @property
    def deviations(self) -> tuple[tuple[float, float], ...]:
        """What the points show: ascending indicated torques, each with indicated less applied, N·m.

        At zero, which a zero step takes off, there is none; points of one direction stand for both.
        """
        if self.interpolation == "cubic":
            return calibration_curve.cubic(self._known)
        return calibration_curve.linear(self._known)

    @property
    def _known(self) -> dict[float, float]:
        known = {point.indicated.si: point.deviation for point in self.points}
        if min(known) >= 0 or max(known) <= 0:
            known = {-indicated: -deviation for indicated, deviation in known.items()} | known
        return known

    @property
    def _off_the_curve(self) -> float:
        if self.interpolation == "cubic":
            return calibration_curve.off_cubic(self._known)
        return calibration_curve.off_linear(self._known)

    @property
    def calibrated_range(self) -> tuple[float, float] | None:
        """Lowest and highest torque, in N·m: both ways alike where `range` has no `min`.

        Where neither range nor points are entered it is full scale, both ways.
        """
        found = super().calibrated_range
        if found is None:
            return -self.full_scale, self.full_scale
        lowest, highest = found
        return (-highest if math.isinf(lowest) else lowest), highest


class OtherInstrument(Instrument):
    """An instrument of any other channel: load cell, angle encoder, thermometer, ..."""

    measures: Annotated[str, AfterValidator(_dimension), Field(json_schema_extra=_name_quantities)]
    """The quantity, such as force, angle or temperature."""
    accuracy: AnyAccuracy | None = None
    """Its limits of error, such as '0.5 % FS', '1 % reading' or '0.2 K', or error by error."""

    @property
    def quantity(self) -> str:
        """The dimension of what it measures."""
        return self.measures

    def limit_of_error(self, value: float) -> float | None:
        """Return what it may be off by at a value, both in the SI unit; None if nothing says it.

        As stated, or else |deviation| + U of the worst calibration point. Full scale is the end of
        the calibrated range.
        """
        reach = self.calibrated_range
        full_scale = reach[1] if reach else math.nan
        if isinstance(self.accuracy, AccuracyInParts):
            return self.accuracy.limit_of_error(value, full_scale)
        if self.accuracy is not None and (reach or not self.accuracy.endswith("FS")):
            return limit_of_error(self.accuracy, value, full_scale)
        limits = [abs(p.deviation) + p.k * p.standard_uncertainty for p in self.points]
        return max(limits, default=None)

    def reading_errors(self, value: float, *, zeroed: bool = False) -> tuple[ReadingError, ...]:
        """Return what a reading may be off by: error by error, or all of it in one line."""
        reach = self.calibrated_range
        if isinstance(self.accuracy, AccuracyInParts):
            found = self.accuracy.errors(self.channel, value, reach[1] if reach else math.nan)
            return tuple(each for each in found if not (zeroed and each.acts == "offset"))
        limit = self.limit_of_error(value)
        if limit is None:
            return ()
        source = "" if self.accuracy else self.certificate
        u = limit / OVER_U["rectangular"]
        return (ReadingError(f"reading of {self.channel}", "each", u, source=source),)

    def _objections(self) -> Iterator[str]:
        yield from super()._objections()
        if isinstance(self.accuracy, AccuracyInParts):
            has_full_scale = self.calibrated_range is not None
            yield from self.accuracy.objections(has_full_scale=has_full_scale)

    def _misread_limits(self) -> Iterator[str]:
        stated: dict[str, str] = {}
        if isinstance(self.accuracy, AccuracyInParts):
            limits = self.accuracy.limits.items()
            stated = {f"accuracy.{name}": each.limit for name, each in limits}
        elif self.accuracy is not None:
            stated = {"accuracy": self.accuracy}
        for name, limit in stated.items():
            if wrong := misread(limit, self.measures):
                yield f"{name} is {wrong}"


def _torque_or_other(value: object) -> str:
    measures = value.get("measures") if isinstance(value, dict) else getattr(value, "quantity", "")
    return "torque" if measures in {None, "torque"} else "other"


AnyInstrument = Annotated[
    Annotated[TorqueInstrument, Tag("torque")] | Annotated[OtherInstrument, Tag("other")],
    Discriminator(_torque_or_other),
]
"""One entry of the register: a torque transducer unless `measures` says something else."""


def torque_instruments(register: Iterable[Instrument]) -> dict[str, TorqueInstrument]:
    """Return the torque transducers of a register by channel."""
    return {each.channel: each for each in register if isinstance(each, TorqueInstrument)}
