"""What keeps a rig safe: the order of making it safe, and how long its devices are waited for."""

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
    """How long a device that may block is waited for, beyond the time that its drives need."""

    connect: PositiveDuration = 10.0
    """Until it has identified itself."""
    answer: PositiveDuration = 10.0
    """Until any other call returns; then it is abandoned and the rig is made safe."""


class Safety(Settings):
    """How the rig is made safe, and what keeps it so."""

    guardian: YesNo = True
    """Whether a second process makes the rig safe when that of a run dies or hangs."""
    order: ListOf[Annotated[str, AfterValidator(_place_in_order)]] = ()
    """In which order drives (role.drive) and whole devices (role) are made safe; the others follow.
    Unless told, what moves in cycles comes first."""
    patience: Waiting = Field(default_factory=Waiting)
    drives: dict[Member, DriveLimits] = Field(default_factory=dict)
    """Narrower limits of drives than their devices' own, by role.drive."""
    combinations: ListOf[Combination] = ()
    """What drives may do at the same time."""
    interlocks: ListOf[Interlock] = ()
    """What is watched throughout every run."""
