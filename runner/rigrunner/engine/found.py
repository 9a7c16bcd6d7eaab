"""What a step found, and of which devices."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.member import Member

NONE: Mapping[str, Any] = {}


@dataclass(slots=True)  # to make a frozen one, or a tuple with names, takes twice as long
class Measured:
    """What a step found, in SI units by 'role.name', and what a simulator knows of it."""

    values: Mapping[str, float]
    units: Mapping[str, str]
    truth: Mapping[str, float]
    statistics: Mapping[str, float] = field(default_factory=dict)
    """Of a recording: what of its samples has limits, in SI units by 'role.name.statistic'."""
    missed: str = ""
    """Of a scan: the value out of limits that ended it, in words."""


NOTHING = Measured(NONE, NONE, NONE)


@lru_cache
def by_role(members: tuple[Member, ...]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Return the channels of each role: a sweep measures the same ones at every point."""
    found: dict[str, list[str]] = {}
    for member in members:
        found.setdefault(member.role, []).append(member.name)
    return tuple((role, tuple(channels)) for role, channels in found.items())
