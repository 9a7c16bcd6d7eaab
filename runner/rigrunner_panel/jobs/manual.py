"""The manual session: a person sets the rig, watches it, and records points."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis.requirements import LEAST_CYCLES, SPARE_CYCLES
from rigrunner.api.data import Recording
from rigrunner.api.errors import DataError, RigrunnerError
from rigrunner.api.events import Samples, StepEnded
from rigrunner.api.member import Member
from rigrunner.bus import EventStamp
from rigrunner.clock import utc_text
from rigrunner.engine.streams import checked_stream
from rigrunner.plan import Plan, PlannedStep
from rigrunner.plan.actions import Phase, Terms
from rigrunner.run.partners import partners_for
from rigrunner.run.planning import planned_run
from rigrunner.steps.record import Record
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.zero import Zero
from rigrunner.tools.by_hand.points import record_by_hand
from rigrunner.tools.by_hand.settling import settle_left
from rigrunner_panel.jobs.overrides import overrides_of
from rigrunner_panel.jobs.screen import Screen
from rigrunner_panel.process import messages
from rigrunner_panel.process.messages import Ended, Watched, Watching
from rigrunner_panel.view.manual import DriveView, ManualView
from rigrunner_panel.view.result import finished_view, live_view

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.data import Array, Block
    from rigrunner.api.events import Event
    from rigrunner.engine.session import Session
    from rigrunner.run.prepare import Planned as PlannedRun
    from rigrunner_panel.process.link import Link
    from rigrunner_panel.process.messages import Job
    from rigrunner_panel.process.watched import WatchedChannels

LOOK_S = 2.0
CYCLES_SEEN = LEAST_CYCLES + SPARE_CYCLES
"""Number of cycles that are recorded and analysed together while watching."""
WATCHED = "watched"
"""The name of a recording that is not stored."""
_CONTINUES = Terms(continues=True)


def manual(job: Job, link: Link) -> Ended:
    """Let a person control the rig until the page is closed."""
    planned = planned_run(job.procedure, job.station, realtime=job.view.realtime)
    screen = Screen(job, link, planned)
    settle_left(job.station, screen.person)
    actions = (step.action for step in planned.plan.steps)
    source = next((action for action in actions if isinstance(action, Record)), None)
    if source is None or source.cycle_frequency_hz is None:
        raise DataError(
            f"{planned.procedure.model.id} records no cycles", hint="choose a procedure that does"
        )
    partners = partners_for(planned, job.runs, job.partners)
    screen.begin(Plan(()), partners)
    hand = Hand(planned, source, link, screen.watched)
    finished = record_by_hand(
        planned,
        hand.steps,
        runs=job.runs,
        partners=partners,
        stop=link.switch,
        pauses=screen.pauses,
        listeners=[link.switch, link.sender, hand],
        operator=job.view.operator,
        overrides=tuple(overrides_of(planned, job)),
        person=screen.person,
    )
    view = None if finished.result is None else live_view(finished.result, final=True)
    return Ended(finished_view(finished), view)


@dataclass(eq=False)
class Hand:
    """Turns manual commands into steps, and watches the rig between them."""

    planned: PlannedRun
    source: Record
    """How the procedure records: its role, channels and units."""
    link: Link
    watched: WatchedChannels
    set_points: dict[str, float] = field(default_factory=dict)
    refused: str = ""
    points: int = 0
    last: str = ""

    def steps(self, session: Session) -> Iterator[PlannedStep]:
        """Yield a step for each command, after the procedure's zero readings at rest."""
        stamp = EventStamp(self.planned.clock)
        self.set_points = dict(self._read_set_points(session))
        yield from self._zeros()
        self._show(session)
        while True:
            session.check()
            command = self.link.commands.by_hand()
            match command:
                case messages.CloseManual():
                    return
                case messages.SetDrive(drive=member, value=value):
                    yield from self._set(session, Member.parse(member), value)
                    # a drive whose set has failed may stand anywhere: it is read back
                    self.set_points = dict(self._read_set_points(session))
                case messages.RecordPoint(cycles=cycles):
                    yield from self._record(session, cycles)
                case _:
                    self._watch(session, stamp)
                    continue
            self._show(session)

    def __call__(self, event: Event) -> None:
        """Receive the result of a recorded point or failed step; an event sink."""
        if isinstance(event, StepEnded):
            if not event.ok:
                self.refused = "it failed: see the alarms"
            elif event.recording:
                self.points, self.last = self.points + 1, event.recording

    @property
    def frequency_hz(self) -> float:
        """The present frequency of the rig; 0 at rest."""
        return self.set_points.get(self._cycle_drive, 0.0)

    @property
    def _cycle_drive(self) -> str:
        role = self.source.role
        drives = self.planned.devices[role].drives
        name = next((drive.name for drive in drives if drive.sets_cycle_frequency), "frequency")
        return Member(role, name)

    def _zeros(self) -> Iterator[PlannedStep]:
        steps = self.planned.plan.steps
        zeros = {step.action: step for step in steps if isinstance(step.action, Zero)}
        yield from (_step("zero", zero, step.text, Terms()) for zero, step in zeros.items())

    def _set(self, session: Session, member: Member, value: float) -> Iterator[PlannedStep]:
        self.refused = ""
        role, name = member.role, member.name
        try:
            allowed = session.rig.allowed(role, name)
        except (RigrunnerError, KeyError) as error:
            self.refused = str(error)
            return
        if not allowed.minimum <= value <= allowed.maximum:
            limits = f"{allowed.minimum:g} to {allowed.maximum:g} {allowed.unit}"
            self.refused = f"{member} may be set to {limits}"
            return
        text = f"Set {member} to {value:g} {allowed.unit}"
        yield _step("set", SetDrive(role, name, value, allowed.unit), text, _CONTINUES)

    def _record(self, session: Session, cycles: int) -> Iterator[PlannedStep]:
        self.refused = ""
        frequency_hz = self.frequency_hz
        if not frequency_hz > 0:
            self.refused = "the rig is at rest: set a frequency first"
            return
        name = f"{self.points + 1:03d}_{frequency_hz:g}Hz"
        # Wherever it begins, a recording has one whole cycle fewer than it lasts.
        seconds = (cycles + 1) / frequency_hz
        action = Record(
            name=name,
            role=self.source.role,
            channels=self.source.channels,
            duration_s=seconds,
            setpoints=dict(self.set_points),
            units=self.source.units,
            cycle_frequency_hz=frequency_hz,
            sample_rate_hz=self.source.sample_rate_hz,
        )
        self._show(session, name)
        text = f"Record {cycles} cycles at {frequency_hz:g} Hz ({seconds:.3g} s)"
        yield _step("record", action, text, _CONTINUES)

    def _watch(self, session: Session, stamp: EventStamp) -> None:
        """Show the rig's readings for a while, unless a command is waiting."""
        if not self.frequency_hz > 0:
            self.watched.look(session.rig)
            session.rig.clock.sleep(0.05)
            return
        seconds = max(LOOK_S, CYCLES_SEEN / self.frequency_hz)
        self.watched.look(session.rig, seconds)
        role, channels, units = self.source.role, self.source.channels, self.source.units
        started_utc, set_points = utc_text(self.planned.clock.utc()), dict(self.set_points)
        self.link.sender.send(Watching(set_points, units))
        blocks: list[Block] = []
        with closing(checked_stream(session, role, channels, seconds)) as stream:
            for block in stream:
                self.link.sender(stamp(Samples, recording="", block=block))
                blocks.append(block)
                if self.link.commands.has_by_hand():
                    return
        watched = Recording(
            name=WATCHED,
            rate_hz=blocks[0].rate_hz,
            started_utc=started_utc,
            setpoints=set_points,
            channels=_join(blocks),
            units=units,
        )
        self.link.sender.send(Watched(watched))

    def _show(self, session: Session, recording: str = "") -> None:
        view = ManualView(
            drives=tuple(self._drives(session)),
            channels=self.source.channels,
            recording=recording,
            refused=self.refused,
            points=self.points,
            last=self.last,
        )
        self.link.show(manual=view)

    def _read_set_points(self, session: Session) -> Iterator[tuple[str, float]]:
        for role, device in self.planned.devices.items():
            for drive in device.drives:
                yield Member(role, drive.name), session.rig.standing(role, drive.name)

    def _drives(self, session: Session) -> Iterator[DriveView]:
        for role, device in self.planned.devices.items():
            for drive in device.drives:
                allowed = session.rig.allowed(role, drive.name)
                yield DriveView(
                    name=Member(role, drive.name),
                    long_name=drive.long_name,
                    unit=drive.unit,
                    minimum=allowed.minimum,
                    maximum=allowed.maximum,
                    set=self.set_points.get(Member(role, drive.name)),
                )


def _step(
    kind: str, action: Zero | SetDrive | Record, text: str, terms: Terms = _CONTINUES
) -> PlannedStep:
    return PlannedStep(f"by_hand.{kind}", Phase.MAIN, action, text, 0.0, terms)


def _join(blocks: list[Block]) -> Mapping[str, Array]:
    return {
        name: np.concatenate([np.asarray(block.channels[name]) for block in blocks])
        for name in blocks[0].channels
    }
