"""What each part of an analysis of torque needs of a run, and the set-points of a plan.

The analysis itself, the rule for gross errors, the primary compensation and the fit that it takes
each state their needs as `TorqueRequirements`. Another compensation than the primary one may turn
out to be not applicable: the run still has its result.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner.api import Member, unit
from rigrunner.api.analysis.requirements import LEAST_CYCLES, SPARE_CYCLES
from rigrunner.api.coordinates import matches
from rigrunner_bearings.api.requirements import (
    LEAST_CYCLES_WITH_RULE,
    LEAST_STARTS,
    TorqueRequirements,
)
from rigrunner_bearings.torque.channels import INDEX

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.analysis_context import Plugins
    from rigrunner.api.planned import PlannedRun, RecordingAction
    from rigrunner_bearings.torque.settings import TorqueSettings

TORQUE = "N·m"


@dataclass(frozen=True)
class Requirer:
    """A part of the analysis with what it needs."""

    name: str
    """In words, such as "the compensation 'energy'"."""
    key: tuple[str | int, ...]
    """Where the settings name it."""
    needs: TorqueRequirements


@dataclass(frozen=True)
class Point:
    """What a recording, or a row of a table, will give the analysis."""

    frequency_hz: float
    loaded: bool
    shows_phase: bool
    """Whether a recorded channel shows the crank phase."""


def requirers(spec: TorqueSettings, plugins: Plugins) -> tuple[Requirer, ...]:
    """Return all parts of an analysis that a run cannot do without; raise PluginError."""
    parts = [_analysis(spec, plugins)]
    if spec.outliers is not None:
        rule = spec.outliers
        needs = TorqueRequirements.of(plugins.requires("outlier_rule", rule.name, rule.settings))
        parts.append(Requirer(f"the rule '{rule.name}'", ("outliers",), needs))
    primary = spec.primary_plugin
    if primary is not None:
        needs = TorqueRequirements.of(
            plugins.requires("compensation", primary.name, primary.settings)
        )
        index = spec.compensations.index(primary)
        parts.append(
            Requirer(f"the compensation '{primary.label}'", ("compensations", index), needs)
        )
        if needs.fit and spec.fits:
            fit = spec.fits[0]
            of_fit = TorqueRequirements.of(plugins.requires("fit", fit.name, fit.settings))
            parts.append(Requirer(f"the fit '{fit.label}'", ("fits", 0), of_fit))
    return tuple(parts)


def _analysis(spec: TorqueSettings, plugins: Plugins) -> Requirer:
    """Return what is needed with any plugins; a rule may reject half of the cycles."""
    name = "the analysis"
    if spec.starts is not None:
        return Requirer(name, (), TorqueRequirements(cycles=LEAST_STARTS))
    if spec.outliers is not None:
        rule = plugins.record("outlier_rule", spec.outliers.name)
        if getattr(rule, "rejects", False):
            name += f", with the rule '{spec.outliers.name}',"
            least = LEAST_CYCLES_WITH_RULE - SPARE_CYCLES
            return Requirer(name, (), TorqueRequirements(cycles=least))
    return Requirer(name, (), TorqueRequirements(cycles=LEAST_CYCLES))


def analysed(planned: PlannedRun, spec: TorqueSettings) -> PlannedRun:
    """Return the part of a plan that is analysed."""
    if not spec.where:
        return planned
    return replace(
        planned,
        recordings=tuple(x for x in planned.recordings if matches(x.coordinates, spec.where)),
        rows=tuple(x for x in planned.rows if matches(x.coordinates, spec.where)),
    )


def points_of(planned: PlannedRun) -> list[Point]:
    """Return the points of a plan: its recordings, or else the rows of its tables with a torque."""
    if planned.recordings:
        return [
            Point(
                frequency_hz=record.cycle_frequency_hz or 0.0,
                loaded=record.setpoints.get(Member(record.role, "load"), 0.0) > 0,
                shows_phase=bool(motion_channels(record)),
            )
            for record in (recording.record for recording in planned.recordings)
        ]
    return list(rows_of(planned))


def rows_of(planned: PlannedRun) -> Iterator[Point]:
    """Yield the rows of tables that have a torque, in motion."""
    for table in planned.rows:
        rows = table.rows
        roles = {name.role for name in rows.channels if rows.units.get(name) == TORQUE}
        for setpoints in rows.setpoints:
            for role in roles:
                frequency_hz = setpoints.get(Member(role, "frequency"), 0.0)
                if frequency_hz > 0:
                    loaded = setpoints.get(Member(role, "load"), 0.0) > 0
                    yield Point(frequency_hz, loaded, shows_phase=False)


def channels_of(record: RecordingAction, dimension: str) -> list[str]:
    """Return the names of the recorded channels of a dimension, such as 'torque'."""
    return [
        name
        for name in record.channels
        if unit(record.units[Member(record.role, name)]).dimension == dimension
    ]


def motion_channels(record: RecordingAction) -> list[str]:
    """Return the names of the recorded channels that show the crank phase of a swing."""
    return [
        *channels_of(record, "angle"),
        *channels_of(record, "angular velocity"),
        *(name for name in record.channels if name == INDEX),
    ]
