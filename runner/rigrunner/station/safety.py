"""Safety of a rig: the order of making it safe, and time limits of its devices."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field

from rigrunner.api.member import NAME, Member
from rigrunner.api.settings import ListOf, PositiveDuration, Settings, YesNo
from rigrunner.interlock import Interlock
from rigrunner.station.limits import Combination, DriveLimits


def _place_in_order(text: str) -> Member | str:
    try:
        return text if re.fullmatch(NAME, text) else Member.parse(text)
    except ValueError:
        message = f"'{text[:40]}' is neither a role nor role.drive, such as tester.load"
        raise ValueError(message) from None


class Waiting(Settings):
    """Time limits of a device that may block, beyond the time that its drives need."""

    connect: PositiveDuration = 10.0
    """Until it has identified itself."""
    answer: PositiveDuration = 10.0
    """Until any other call returns; after it the call is abandoned and the rig is made safe."""


class Safety(Settings):
    """How the rig is made and kept safe."""

    guardian: YesNo = True
    """Whether a second process makes the rig safe if that of a run dies or hangs."""
    order: ListOf[Annotated[str, AfterValidator(_place_in_order)]] = ()
    """Order in which drives (role.drive) and whole devices (role) are made safe; the others follow.
    By default cyclically moving devices come first."""
    patience: Waiting = Field(default_factory=Waiting)
    drives: dict[Member, DriveLimits] = Field(default_factory=dict)
    """Tighter limits of drives than those of their devices, by role.drive."""
    combinations: ListOf[Combination] = ()
    """Drives that must not all be high at the same time."""
    interlocks: ListOf[Interlock] = ()
    """Conditions that are monitored throughout every run."""
