"""What a certificate or a data sheet says of a torque transducer's errors, each with its source.

The names are those of DIN 51309, VDI/VDE 2646 and ISO 376.
"""

from __future__ import annotations

import re
from math import inf
from typing import TYPE_CHECKING, Annotated, NamedTuple

from pydantic import AfterValidator, Field

from rigrunner.api.accuracy import OVER_U
from rigrunner.api.calibration import Accuracy, limit_of_error
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.reading_errors import ReadingError, Shape
from rigrunner.api.settings import Difference, PlainText, Settings
from rigrunner.api.units import QuantityError

if TYPE_CHECKING:
    from collections.abc import Iterator


def _of_torque(text: str) -> str:
    if "%" not in text:
        found = parse_quantity(text)
        if found.dimension != "torque":
            hint = "such as '0.02 % reading', '0.02 % FS' or '0.002 N·m'"
            raise QuantityError(f"'{text}' is a {found.dimension}, needed is a torque", hint=hint)
    return text


class Limit(NamedTuple):
    """Half the width of a distribution: a part of each reading, and a torque in N·m."""

    of_reading: float
    torque_nm: float


class StatedError(Settings):
    """One error of a transducer: how large it may be, and who says so."""

    limit: Annotated[
        Accuracy,
        AfterValidator(_of_torque),
        Field(description="'0.02 % reading', '0.02 % FS' or a torque: it is within ± this"),
    ]
    distribution: Shape = "rectangular"
    """Of `normal` the limit is two standard uncertainties, of the others the half-width."""
    source: Annotated[
        PlainText,
        Field(min_length=1, max_length=80, description="certificate or data sheet that states it"),
    ]

    def half_width(self, full_scale: float) -> Limit:
        """Return the limit in its parts, of a transducer of that full scale in N·m."""
        if re.search(r"%\s*reading$", self.limit):
            return Limit(limit_of_error(self.limit, 1.0, full_scale), 0.0)
        return Limit(0.0, limit_of_error(self.limit, 0.0, full_scale))


class TemperatureError(StatedError):
    """An error that grows with the temperature."""

    per: Difference
    """For how much warmer the limit is stated, such as 10 K."""
    within: Difference
    """How far the temperature may be away: from that of the calibration, or since the zero step."""

    def half_width(self, full_scale: float) -> Limit:
        """Return the limit over `within`."""
        of_reading, torque_nm = super().half_width(full_scale)
        times = self.within.si / self.per.si
        return Limit(times * of_reading, times * torque_nm)


class TransducerErrors(Settings):
    """Errors of a torque transducer beyond its `accuracy`; what is left out adds nothing."""

    repeatability: StatedError | None = None
    """Between readings of the same torque, b' of DIN 51309."""
    hysteresis: StatedError | None = None
    """Between rising and falling torque, h of DIN 51309: half of the difference."""
    resolution: StatedError | None = None
    """The smallest step of the reading, r: it may be off by half of that."""
    creep: StatedError | None = None
    """Under a lasting torque."""
    temperature_zero: TemperatureError | None = None
    """Of the zero (TK0)."""
    temperature_sensitivity: TemperatureError | None = None
    """Of the sensitivity (TKC)."""

    def reading_errors(
        self, channel: str, value: float, full_scale: float
    ) -> Iterator[ReadingError]:
        """Yield a line for each error at a value, of a transducer of that full scale, in N·m."""
        for name, each in self:
            if each is None:
                continue
            of_reading, torque_nm = each.half_width(full_scale)
            gain = name == "temperature_sensitivity"
            width = of_reading if gain else of_reading * abs(value) + torque_nm
            yield ReadingError(
                f"{name.replace('_', ' ')} of {channel}",
                "gain" if gain else "each",
                (0.5 if name == "resolution" else 1.0) * width / OVER_U[each.distribution],
                inf,
                each.distribution,
                each.source,
            )
