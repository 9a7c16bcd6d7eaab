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
    """What a calibration lacks; also the names by which a person may override it."""

    MISSING = "missing"
    OVERDUE = "overdue"
    RANGE = "range"


@dataclass(frozen=True)
class Finding:
    """Why an instrument may not be used for a run."""

    lack: Lack
    channel: str
    names: tuple[str, ...]
    """Names of the instrument: channel, the laboratory's number, serial number."""
    problem: Problem

    @property
    def key(self) -> str:
        """The short name in the record, such as 'overdue tester.torque'."""
        return f"{self.lack} {self.channel}"


def require_calibrated(planned: Planned, overridden: Container[str] = ()) -> None:
    """Raise InvalidFileError with all `calibration_findings` whose keys are not overridden."""
    findings = calibration_findings(planned)
    problems = [finding.problem for finding in findings if finding.key not in overridden]
    if problems:
        raise InvalidFileError(problems)


def calibration_findings(planned: Planned) -> tuple[Finding, ...]:
    """Return why instruments of a planned run may not be used, on the clock's day.

    Every channel whose value enters the result is checked. On a simulated device nothing has to be
    registered, but entries are checked. An instrument of a trial needs no calibration: its values
    cannot be certified.
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
        register = self.planned.station.register
        for channel in entering_channels(self.planned):
            if channel not in register:
                if not self._is_simulated(channel):
                    message = f"there is no instrument for {channel}, whose value enters the result"
                    hint = f"enter it; {_override_hint(channel)}"
                    problem = self._problem(("instruments",), message, hint)
                    yield Finding(Lack.MISSING, channel, (channel,), problem)
                continue
            instrument = register[channel]
            label = _label(instrument)
            yield from self._missing(instrument)
            if instrument.calibrated is not None and instrument.calibrated > today:
                message = f"{label} was calibrated on {instrument.calibrated}, after this run"
                hint = "correct the date, or enter the calibration before"
                yield self._finding(Lack.MISSING, instrument, "calibrated", message, hint)
            if instrument.due is not None and instrument.due < today:
                days = (today - instrument.due).days
                ago = f"{days} day{'s' if days > 1 else ''} before this run"
                message = f"the calibration of {label} was due on {instrument.due}, {ago}"
                hint = "have it calibrated and enter the new certificate"
                yield self._finding(Lack.OVERDUE, instrument, "due", message, hint)
            elif instrument.due is not None and instrument.due < last:
                message = f"the calibration of {label} is due on {instrument.due}"
                message += f", and this run may last until {last}"
                hint = "have it calibrated before, and enter the new certificate"
                yield self._finding(Lack.OVERDUE, instrument, "due", message, hint)
            yield from self._out_of_range(instrument)

    def _missing(self, instrument: Instrument) -> Iterator[Finding]:
        simulated = self._is_simulated(instrument.channel)
        if instrument.calibration == "trial":
            return
        if instrument.calibration is not None and not simulated:
            plugin, _ = self._source(instrument.channel)
            message = f"{_label(instrument)} is entered as {instrument.calibration}"
            message += f", but what '{plugin}' gives was measured"
            hint = "enter its certificate and due in place of calibration"
            yield self._finding(Lack.MISSING, instrument, "calibration", message, hint)
        elif instrument.calibration is None and not simulated:
            without = [name for name in ("certificate", "due") if not getattr(instrument, name)]
            if without:
                message = f"{_label(instrument)} has no {' and no '.join(without)}"
                hint = f"enter {' and '.join(without)} of its calibration"
                yield self._finding(Lack.MISSING, instrument, "", message, hint)

    def _out_of_range(self, instrument: Instrument) -> Iterator[Finding]:
        bounds = instrument.calibrated_range
        simulated = self._is_simulated(instrument.channel) or instrument.calibration == "trial"
        # Nothing has to be entered for a simulated device, but entries are checked.
        if simulated and not (instrument.range_ or instrument.points):
            return
        if bounds is None:
            if not simulated:
                message = f"{_label(instrument)} has no calibrated range"
                yield self._finding(Lack.RANGE, instrument, "", message, "enter range or points")
            return
        (lowest, highest), quantity = bounds, instrument.quantity
        uses = self._uses(instrument)
        outside = [(value, what) for value, what in uses if not lowest <= value <= highest]
        if outside:
            worst, what = max(outside, key=lambda use: abs(use[0]))
            span = f"up to {_short(highest, quantity)}"
            if not isinf(lowest):
                span = f"from {_short(lowest, quantity)} to {_short(highest, quantity)}"
            hint = "use an instrument calibrated for this value, or have this one calibrated for it"
            field = (
                "range" if instrument.range_ else "points" if instrument.points else "full_scale"
            )
            message = f"{_label(instrument)} is calibrated {span}"
            message += f", but {what} {_short(worst, quantity)}"
            yield self._finding(Lack.RANGE, instrument, field, message, hint)

    def _uses(self, instrument: Instrument) -> Iterator[tuple[float, str]]:
        """Yield the expected values of an instrument, as far as they are known beforehand.

        In the SI unit of the channel, each with a text.
        """
        expected = [reading for reading in self.expected if reading.channel == instrument.channel]
        for reading in expected:
            yield from ((value, reading.text) for value in (reading.low, reading.high))
        if expected:
            return
        # Else the set-points of the drive of the same name; 0 needs no calibration point.
        for step in self.planned.plan.steps:
            if step.action.moves == instrument.channel:
                text = f"{instrument.channel} is set to"
                yield from ((value, text) for value in step.action.moves_to if value)

    def _is_simulated(self, channel: Member) -> bool:
        return self.planned.registry.is_simulated(*self._source(channel))

    def _source(self, channel: Member) -> tuple[str, Mapping[str, Any]]:
        """Return plugin and settings of the device that the channel comes from."""
        role, name = channel.role, channel.name
        device = self.planned.station.model.devices[role]
        return self.planned.registry.source(device.plugin, device.settings, name)

    def _finding(
        self, lack: Lack, instrument: Instrument, field: str, message: str, hint: str
    ) -> Finding:
        index = self.planned.station.model.instruments.index(instrument)
        path: Path = ("instruments", index, *((field,) if field else ()))
        names = tuple(filter(None, (instrument.channel, instrument.id, instrument.serial)))
        problem = self._problem(path, message, f"{hint}; {_override_hint(instrument.name)}")
        return Finding(lack, instrument.channel, names, problem)

    def _problem(self, path: Path, message: str, hint: str) -> Problem:
        return Problem(message, self.planned.station.document.where(path), dotted(path), hint)


def entering_channels(planned: Planned) -> tuple[Member, ...]:
    """Return the channels whose values enter the result, each once.

    Of a procedure without an analysis these are all that it records and measures, except pulses, of
    which only the time counts. Of one with analyses: the channels that these state, or else need;
    and, if one does not state any, those whose values have limits.
    """
    analyses = planned.procedure.model.analyses_at
    return tuple(dict.fromkeys(_of_analyses(planned) if analyses else _measured(planned)))


def _measured(planned: Planned) -> Iterator[Member]:
    recordings = {recording.record.name: recording.record for recording in planned.plan.recordings}
    for step in planned.plan.steps:
        if record := recordings.get(step.action.recording):
            yield from (Member(record.role, name) for name in record.channels if name != _PULSES)
        if rows := step.action.rows:
            yield from rows.channels


def _of_analyses(planned: Planned) -> Iterator[Member]:
    """Yield the channels that analyses state or need; a set-point only if it is in the register."""
    registry, to_come = planned.registry, planned.to_come()
    names: set[str] = {name for planned_rows in to_come.rows for name in planned_rows.rows.channels}
    names |= {instrument.channel for instrument in planned.station.model.instruments}
    names |= {
        f"{recording.record.role}.{name}"
        for recording in planned.plan.recordings
        for name in recording.record.channels
    }
    all_stated = True
    for _, plugin in planned.procedure.model.analyses_at:
        entering = registry.entering(plugin.name, plugin.settings, to_come)
        if entering is not None:
            yield from map(channel_of, entering)
            continue
        all_stated = False
        requirements = registry.requires(plugin.kind, plugin.name, plugin.settings)
        for channel in requirements.channels:
            if not channel.or_coordinate or channel.name in names:
                yield channel_of(channel.name)
    for step in () if all_stated else planned.plan.steps:
        for limit in step.limits:
            role, name, *_ = limit.of.split(".")  # and a statistic of a recording
            yield Member(role, name)


def _override_hint(name: str) -> str:
    """Return how to start nevertheless."""
    return f"or start with --override {name} --by NAME --reason TEXT"


def _label(instrument: Instrument) -> str:
    """Return 'TQ-7 (tester.torque)'."""
    return f"{instrument.name} ({instrument.channel})"


def _short(si: float, dimension: str) -> str:
    written = readable(si, dimension)
    return f"{written.number:.4g} {written.unit.symbol}"
