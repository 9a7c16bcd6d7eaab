"""The contracts of torque, for packages with compensations; they add to `rigrunner.api`.

The record of such a plugin is here; its inputs and outputs are in the modules. None loads numpy.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from rigrunner.api.hooks import PluginRecord, needs_nothing

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import Requirements
    from rigrunner_bearings.api.compensations import CompensationMethod
    from rigrunner_bearings.api.measurand import MeasurandKind


class Influence(StrEnum):
    """What a compensation's result does not depend on, unless its record says so."""

    TIME_SHIFT = "when a recording begins"
    SAMPLE_RATE = "the sampling rate"
    TORQUE_OFFSET = "an offset of the torque in both runs"
    ORDER = "the order of the recordings"


@dataclass(frozen=True, kw_only=True)
class CompensationRecord(PluginRecord):
    """A way to subtract the rig's no-load torque: `factory(settings)`."""

    factory: Callable[[Any], CompensationMethod]
    """Makes the method, of the settings."""
    yields: MeasurandKind | None = None
    """Which torque comes out; without it no limit can be applied to the result.

    A method that yields the total torque yields the no-load torque where there is no load.
    """
    moved_by: frozenset[Influence] = frozenset()
    """Which influences move its result, by its principle."""
    not_covered: str = ""
    """Of a method with a known bias: why its interval need not hold the truth."""
    requires: Callable[[Any], Requirements] = needs_nothing
    """Gives, of the settings, what the method needs of a run: without it, the method would be not
    applicable. Of the primary method it is checked before the rig moves."""
