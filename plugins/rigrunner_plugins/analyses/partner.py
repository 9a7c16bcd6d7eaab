"""Budgets of two runs that are compared: an instrument error common to both counts once.

A gain or an offset of an instrument that was calibrated once is one error. Its sensitivity for the
difference or quotient is the sum of both sensitivities (GUM 5.2.2 with r = 1): an offset cancels in
a difference, a gain in a quotient. An error stated as one figure may differ between readings, as
scatter does, so each run has its own budget line for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isclose
from typing import TYPE_CHECKING

from rigrunner.api import DataError
from rigrunner.api.member import channel_of
from rigrunner.api.places import SAME, is_at
from rigrunner_plugins.analyses.sources import parts

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Component, RunData
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.planned import PlannedRun
    from rigrunner_plugins.analyses.settings import ReadingsSettings
    from rigrunner_plugins.analyses.sources import Group


@dataclass(frozen=True, eq=False)
class Partner:
    """The run that is subtracted or divided by, with its values by place."""

    run: RunData
    groups: Sequence[Group]
    per: tuple[str, ...]
    words: str

    def group_at(self, group: Group) -> Group:
        """Return its values at the place of a group of the other run; raise DataError for none."""
        for candidate in self.groups:
            if all(_is_same(candidate.place[name], group.place[name]) for name in self.per):
                return candidate
        place = ", ".join(f"{name} = {group.place[name]}" for name in self.per)
        raise DataError(f"the {self.words}, {self.run.run_id}, has nothing at {place}")

    def line_suffixes(self, run: RunData, group: Group) -> dict[str, str]:
        """Return the suffix for budget lines of a channel read by another instrument."""
        ours, theirs = run.instruments, self.run.instruments
        channels = {name: channel_of(name) for name in group.values}
        return {
            name: f", {self.words}"
            for name, channel in channels.items()
            if ours.get(channel) is None or theirs.get(channel) != ours[channel]
        }


def partner_problems(settings: ReadingsSettings, _: PlannedRun, partner: RunData) -> Iterator[str]:
    """Yield why a run cannot be subtracted or divided by: it would be a mean over several places.

    Such as of a reading without a filter at each frequency, where that at one is meant.
    """
    compared = settings.compared
    if compared is None or compared.per is not None:
        return
    measured = parts(partner, settings.channels, settings.table)
    places = [part.place for part in measured if is_at(compared.where, part.place)]
    for name in settings.per:
        count = len({place[name].usual for place in places if name in place})
        if count > 1:
            yield (
                f"it has {count} values of {name}: write 'per: {name}' for the one at each, or"
                " 'per: []' for one over all"
            )


def joint_budget(
    lines: Sequence[Component], partner_lines: Sequence[Component], words: str
) -> Iterator[Component]:
    """Yield the lines of both budgets; lines of the same name become one.

    `partner_lines` already have the sensitivities of the difference or quotient.
    """
    remaining = {line.name: line for line in partner_lines}
    for line in lines:
        other = remaining.get(line.name)
        if other is not None and line.shared and other.shared and line.common and other.common:
            yield _merged(line, remaining.pop(line.name))
        else:
            yield line
    for line in remaining.values():
        name = line.name if line.name.endswith(f", {words}") else f"{line.name}, {words}"
        yield replace(line, name=name)


def _merged(line: Component, other: Component) -> Component:
    signed = line.sensitivity * line.input_u + other.sensitivity * other.input_u
    sensitivity = signed / line.input_u if line.input_u else 0.0
    return replace(line, u=abs(signed), sensitivity=sensitivity)


def _is_same(one: CoordinateValue, other: CoordinateValue) -> bool:
    first, second = one.usual, other.usual
    if isinstance(first.value, str) or isinstance(second.value, str):
        return first.value == second.value
    return first.unit == second.unit and isclose(
        first.value, second.value, rel_tol=SAME, abs_tol=1e-12
    )
