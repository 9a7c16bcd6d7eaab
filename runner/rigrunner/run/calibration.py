"""Whether every instrument of a planned run is calibrated for it: on record, in time, in range."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta
from enum import StrEnum
from math import isinf
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.api.member import Member, channel_of
from rigrunner.api.quantity import readable
from rigrunner.yamlfile.document import dotted

if TYPE_CHECKING:
    from collections.abc import Container, Iterator, Mapping

    from rigrunner.api.instruments import Instrument
    from rigrunner.api.planned import ExpectedReading
    from rigrunner.run.prepare import Planned
    from rigrunner.yamlfile.document import Path

_PULSES = "index"
"""The name of a channel of pulses."""


class Lack(StrEnum):
    """What a calibration lacks; the words by which a person may override it."""

    MISSING = "missing"
    OVERDUE = "overdue"
    RANGE = "range"


@dataclass(frozen=True)
class Finding:
    """Why an instrument may not be used for a run."""

    lack: Lack
    channel: str
    names: tuple[str, ...]
    """By which it may be called: channel, the laboratory's number, serial number."""
    problem: Problem

    @property
    def key(self) -> str:
        """The short name by which it is put on record, such as 'overdue tester.torque'."""
        return f"{self.lack} {self.channel}"


def require_calibrated(planned: Planned, but: Container[str] = ()) -> None:
    """Raise InvalidFileError with all that `calibration_findings` finds but these, by their key."""
    left = [each.problem for each in calibration_findings(planned) if each.key not in but]
    if left:
        raise InvalidFileError(left)


def calibration_findings(planned: Planned) -> tuple[Finding, ...]:
    """Return what keeps the instruments of a planned run from being used, on the clock's day.

    Looked at is every channel whose value enters the result. On a simulated device nothing has to
    be registered, but what is entered is held to. An instrument of a trial needs no calibration:
    what it measures cannot be certified.
    """
    return tuple(_Register(planned, planned.expected()).findings())


@dataclass(frozen=True)
class _Register:
    planned: Planned
    expected: tuple[ExpectedReading, ...]
    """What channels will probably show."""

    def findings(self) -> Iterator[Finding]:
        now = self.planned.clock.utc()
        today = now.date()
        last = (now + timedelta(seconds=self.planned.plan.estimated_s)).date()
        known = self.planned.station.register
        for channel in entering_channels(self.planned):
            if channel not in known:
                if not self._is_simulated(channel):
                    message = f"there is no instrument for {channel}, whose value enters the result"
                    problem = self._problem(("instruments",), message, f"enter it; {_way(channel)}")
                    yield Finding(Lack.MISSING, channel, (channel,), problem)
                continue
            each = known[channel]
            yield from self._missing(each)
            if each.calibrated is not None and each.calibrated > today:
                message = f"{_named(each)} was calibrated on {each.calibrated}, after this run"
                hint = "correct the date, or enter the calibration before"
                yield self._entered(Lack.MISSING, each, "calibrated", message, hint)
            if each.due is not None and each.due < today:
                days = (today - each.due).days
                ago = f"{days} day{'s' if days > 1 else ''} before this run"
                message = f"the calibration of {_named(each)} was due on {each.due}, {ago}"
                hint = "have it calibrated and enter the new certificate"
                yield self._entered(Lack.OVERDUE, each, "due", message, hint)
            elif each.due is not None and each.due < last:
                message = f"the calibration of {_named(each)} is due on {each.due}"
                message += f", and this run may last until {last}"
                hint = "have it calibrated before, and enter the new certificate"
                yield self._entered(Lack.OVERDUE, each, "due", message, hint)
            yield from self._out_of_range(each)

    def _missing(self, each: Instrument) -> Iterator[Finding]:
        simulated = self._is_simulated(each.channel)
        if each.calibration == "trial":
            return
        if each.calibration is not None and not simulated:
            plugin, _ = self._source(each.channel)
            message = f"{_named(each)} is entered as {each.calibration}, but what '{plugin}' gives"
            message += " was measured"
            hint = "enter its certificate and due in place of calibration"
            yield self._entered(Lack.MISSING, each, "calibration", message, hint)
        elif each.calibration is None and not simulated:
            without = [name for name in ("certificate", "due") if not getattr(each, name)]
            if without:
                message = f"{_named(each)} has no {' and no '.join(without)}"
                hint = f"enter {' and '.join(without)} of its calibration"
                yield self._entered(Lack.MISSING, each, "", message, hint)

    def _out_of_range(self, each: Instrument) -> Iterator[Finding]:
        bounds = each.calibrated_range
        simulated = self._is_simulated(each.channel) or each.calibration == "trial"
        # Nothing has to be entered for a simulated device, but what is entered is held to.
        if simulated and not (each.range_ or each.points):
            return
        if bounds is None:
            if not simulated:
                message = f"{_named(each)} has no calibrated range"
                yield self._entered(Lack.RANGE, each, "", message, "enter range or points")
            return
        lowest, highest = bounds
        uses = self._uses(each)
        outside = [(value, what) for value, what in uses if not lowest <= value <= highest]
        if outside:
            worst, what = max(outside, key=lambda use: abs(use[0]))
            span = f"up to {_short(highest, each.quantity)}"
            if not isinf(lowest):
                span = f"from {_short(lowest, each.quantity)} to {_short(highest, each.quantity)}"
            hint = "use an instrument calibrated for this value, or have this one calibrated for it"
            field = "range" if each.range_ else "points" if each.points else "full_scale"
            message = f"{_named(each)} is calibrated {span}"
            message += f", but {what} {_short(worst, each.quantity)}"
            yield self._entered(Lack.RANGE, each, field, message, hint)

    def _uses(self, each: Instrument) -> Iterator[tuple[float, str]]:
        """Yield what the plan will put on an instrument, as far as it is known beforehand.

        In the SI unit of the channel, with words for it.
        """
        expected = [one for one in self.expected if one.channel == each.channel]
        for one in expected:
            yield from ((value, one.text) for value in (one.low, one.high))
        if expected:
            return
        # Else the set-points of the drive of the same name; 0 needs no calibration point.
        for step in self.planned.plan.steps:
            if step.action.led == each.channel:
                said = f"{each.channel} is set to"
                yield from ((value, said) for value in step.action.passes if value)

    def _is_simulated(self, channel: Member) -> bool:
        return self.planned.registry.is_simulated(*self._source(channel))

    def _source(self, channel: Member) -> tuple[str, Mapping[str, Any]]:
        """Return plugin and settings of the device that the channel comes from."""
        role, name = channel.role, channel.name
        device = self.planned.station.model.devices[role]
        return self.planned.registry.source(device.plugin, device.settings, name)

    def _entered(
        self, lack: Lack, each: Instrument, field: str, message: str, hint: str
    ) -> Finding:
        index = self.planned.station.model.instruments.index(each)
        path: Path = ("instruments", index, *((field,) if field else ()))
        names = tuple(name for name in (each.channel, each.id, each.serial) if name)
        problem = self._problem(path, message, f"{hint}; {_way(each.name)}")
        return Finding(lack, each.channel, names, problem)

    def _problem(self, path: Path, message: str, hint: str) -> Problem:
        return Problem(message, self.planned.station.document.where(path), dotted(path), hint)


def entering_channels(planned: Planned) -> tuple[Member, ...]:
    """Return the channels whose values enter the result, each once.

    Of a procedure without an analysis these are all that it records and measures, but for pulses,
    of which only the time counts. Of one with analyses: the channels that these say, or else need;
    and, where one does not say which, those whose values have limits.
    """
    analyses = planned.procedure.model.analyses_at
    return tuple(dict.fromkeys(_of_analyses(planned) if analyses else _measured(planned)))


def _measured(planned: Planned) -> Iterator[Member]:
    recordings = {each.record.name: each.record for each in planned.plan.recordings}
    for step in planned.plan.steps:
        if record := recordings.get(step.action.recording):
            yield from (Member(record.role, each) for each in record.channels if each != _PULSES)
        if rows := step.action.rows:
            yield from rows.channels


def _of_analyses(planned: Planned) -> Iterator[Member]:
    """Yield the channels that analyses say or need; a set-point alone if the register has it."""
    registry, to_come = planned.registry, planned.to_come()
    known: set[str] = {name for each in to_come.rows for name in each.rows.channels}
    known |= {each.channel for each in planned.station.model.instruments}
    known |= {
        f"{each.record.role}.{name}"
        for each in planned.plan.recordings
        for name in each.record.channels
    }
    says_all = True
    for _, plugin in planned.procedure.model.analyses_at:
        entering = registry.entering(plugin.name, plugin.settings, to_come)
        if entering is not None:
            yield from map(channel_of, entering)
            continue
        says_all = False
        needed = registry.requires(plugin.kind, plugin.name, plugin.settings)
        for each in needed.channels:
            if not each.or_coordinate or each.name in known:
                yield channel_of(each.name)
    for step in () if says_all else planned.plan.steps:
        for limit in step.limits:
            role, name, *_ = limit.of.split(".")  # and a statistic of a recording
            yield Member(role, name)


def _way(name: str) -> str:
    """Say how to start nevertheless."""
    return f"or start with --override {name} --by NAME --reason TEXT"


def _named(each: Instrument) -> str:
    """Return 'TQ-7 (tester.torque)'."""
    return f"{each.name} ({each.channel})"


def _short(si: float, dimension: str) -> str:
    written = readable(si, dimension)
    return f"{written.number:.4g} {written.unit.symbol}"
