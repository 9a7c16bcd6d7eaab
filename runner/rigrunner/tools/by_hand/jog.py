"""Set and read one device manually, within the limits and interlocks of its station."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.devices import Readable, Streaming
from rigrunner.api.errors import (
    DataError,
    DeviceError,
    DeviceRejectedError,
    RigrunnerError,
    UsageError,
)
from rigrunner.api.events import Alarm, Intervention, MadeSafe, Note
from rigrunner.api.member import Member
from rigrunner.api.quantity import entered_si, legible
from rigrunner.api.units import unit
from rigrunner.bus import Bus, Emitter
from rigrunner.engine import UnattendedAnswers
from rigrunner.engine.interlocks import Guard
from rigrunner.engine.notes import error_line
from rigrunner.engine.pausing import PauseRequestedError
from rigrunner.engine.session import Session
from rigrunner.rig import unsafe_text
from rigrunner.run.guardian.guarding import unguarded
from rigrunner.run.left_energised import NOBODY, LeftAsItStandsError, check_left
from rigrunner.run.log import RunLog, with_units
from rigrunner.run.overrides import without_time_limits
from rigrunner.station.drive_rules import DriveRules
from rigrunner.steps.measure import Measure
from rigrunner.steps.set_drives import SetDrive
from rigrunner.yamlfile.problems import suggestion

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
    from contextlib import AbstractContextManager
    from pathlib import Path

    from rigrunner.api.devices import ChannelInfo, DriveInfo, StopToken
    from rigrunner.api.events import Event, EventSink
    from rigrunner.rig import Rig, SafetyReport
    from rigrunner.run.left_energised import Person
    from rigrunner.tools.by_hand.station import ReadyStation

_T = TypeVar("_T")
_STEP = "jog"
_MEAN_S, _ZERO_S, _WATCH_EVERY_S = 0.2, 1.0, 0.2
_ROUNDING_S = 1e-9


class Jog:
    """A connected device, and the actions on it.

    A UsageError is raised before anything is sent. After any other error the rig is made safe.
    """

    def __init__(self, ready: ReadyStation, role: str, rig: Rig, session: Session) -> None:
        safety = ready.station.model.safety
        rules = DriveRules(safety.drives, safety.combinations)
        device = ready.devices[role]
        self.role = role
        self.channels: Mapping[str, ChannelInfo] = {info.name: info for info in device.channels}
        self.drives: Mapping[str, DriveInfo] = {
            info.name: rules.narrowed(Member(role, info.name), info) for info in device.drives
        }
        self.zeros: dict[str, float] = {}
        """Subtracted from a channel's values, in SI units."""
        self.unsafe = ""
        """What was not safe when the rig was last made safe, as text."""
        self._device = device
        self._rig = rig
        self._session = session

    def person(self) -> AbstractContextManager[None]:
        """Suspend the time limits while a person is asked."""
        return self._rig.person()

    def check_interlocks(self) -> None:
        """Read all interlocks, and raise on one that is tripped."""
        self._execute("look", lambda: self._session.check(read_all=True))

    def set(self, drive: str, text: str) -> float:
        """Set a drive to a set-point such as '5 Hz', and return its read-back in SI units."""
        info = _lookup("drive", drive, self.drives)
        value = entered_si(drive, text, unit(info.unit).dimension)
        if not info.minimum <= value <= info.maximum:
            raise UsageError(f"{drive}: {text} is out of range ({info.range_text})")
        self.check_interlocks()
        action = SetDrive(self.role, drive, value, info.unit)
        what = f"set {drive} {text}"
        measured = self._execute(what, lambda: action.do(_STEP, self._session))
        actual = measured.values[Member(self.role, drive)]
        self._note(f"{what}: reads back {legible(actual, info.unit)}")
        return actual

    def read(self, names: Sequence[str] = ()) -> dict[str, float]:
        """Return the value of each channel, by default of all, minus its zero; in SI units."""
        for name in names:
            _lookup("channel", name, self.channels)
        if not names:
            single = isinstance(self._device, Readable)
            names = [name for name, info in self.channels.items() if single or info.streams]
        values = self._values(names)
        units = {name: self.channels[name].unit for name in values}
        self._note(f"read {with_units(values, units)}")
        return values

    def watch(self, name: str, seconds: float) -> Iterator[float]:
        """Yield a channel's value, minus its zero, again and again for that time, at least once."""
        _lookup("channel", name, self.channels)
        clock = self._session.rig.clock
        until_s = clock.monotonic_s() + seconds - _ROUNDING_S
        self._note(f"watch {name} for {seconds:g} s")
        while True:
            self.check_interlocks()
            yield self._values((name,))[name]
            clock.sleep(_WATCH_EVERY_S)
            if clock.monotonic_s() >= until_s:
                return

    def zero(self, name: str) -> float:
        """Take the present value of a channel (its mean if it streams) as its zero; return it."""
        _lookup("channel", name, self.channels)
        self.zeros.pop(name, None)
        self.zeros[name] = self._values((name,), mean=True)[name]
        self._note(f"zero {name}: {legible(self.zeros[name], self.channels[name].unit)}")
        return self.zeros[name]

    def read_backs(self) -> dict[str, float]:
        """Return the read-back of each drive, in SI units."""
        return {
            name: self._execute("read back", partial(self._rig.read_back, self.role, name))
            for name in self.drives
        }

    def safe(self) -> tuple[SafetyReport, ...]:
        """Make the rig safe, and log how."""
        reports = self._make_safe()
        for report in reports:
            self._session.emit(
                MadeSafe,
                what=report.what,
                read_back=report.by_member(report.read_back),
                units=report.by_member(report.units),
                problems=report.problems,
            )
        return reports

    def _values(self, names: Sequence[str], *, mean: bool = False) -> dict[str, float]:
        """Return values minus their zeros; means, if asked or if channels can only be streamed."""
        device, rate_hz = self._device, None
        if mean or not isinstance(device, Readable):
            streams = all(self.channels[name].streams for name in names)
            rate_hz = device.sample_rate_hz if streams and isinstance(device, Streaming) else None
        duration_s = _ZERO_S if mean else _MEAN_S if rate_hz else 0.0
        members = [Member(self.role, name) for name in names]
        units: dict[str, str] = {member: self.channels[member.name].unit for member in members}
        action = Measure(_STEP, tuple(members), duration_s, {}, units, rate_hz)
        what = f"read {', '.join(names)}"
        values = self._execute(what, lambda: action.do(_STEP, self._session)).values
        return {name: values[Member(self.role, name)] - self.zeros.get(name, 0.0) for name in names}

    def _execute(self, what: str, work: Callable[[], _T]) -> _T:
        """Execute an action on the rig; on any error, make the rig safe before it is raised."""
        try:
            return work()
        except PauseRequestedError as pause:
            self._on_error(what, pause)
            hint = "nothing is set until it clears"
            raise DeviceRejectedError(pause.message, hint=hint) from pause
        except BaseException as error:
            self._on_error(what, error)
            raise

    def _on_error(self, what: str, error: BaseException) -> None:
        try:
            self._session.emit(Alarm, source=f"{_STEP}: {what}", text=error_line(error))
        finally:
            self.safe()

    def _note(self, text: str) -> None:
        try:
            self._session.emit(Note, step=f"{_STEP} {self.role}", text=text)
        except BaseException:  # every manual action must be on record
            self._make_safe()
            raise

    def _make_safe(self) -> tuple[SafetyReport, ...]:
        reports = self._rig.make_safe()
        self.unsafe = unsafe_text(reports)
        return reports


@contextmanager
def jogging(
    ready: ReadyStation,
    role: str,
    log: Path,
    stop: StopToken,
    listeners: Iterable[EventSink] = (),
    *,
    person: Person = NOBODY,
) -> Iterator[Jog]:
    """Connect a device, and those that its interlocks and combinations need, and yield it.

    However the block ends, the rig is made safe and closed. Every action is logged; if the log
    fails, the block ends. Raises UsageError for an unknown role, DataError if the log cannot be
    written, and a DeviceError if the rig cannot be connected, or is not safe at the end.
    """
    _lookup("device in the role", role, ready.devices)
    what, needed = f"jog {role}", _needed_roles(ready, role)
    with (
        ready.hold(what) as held,
        _open_log(log) as sink,
        held.guarded(what, needed) as guardian,
    ):
        rig = held.rig(needed, guardian.pulse if guardian else None)
        guardian_sinks = [guardian.pulse.note] if guardian else []
        bus = Bus(critical=[sink], guarded=[*guardian_sinks, *listeners])
        emit = Emitter(bus, held.clock)
        replay = ", played back from a tape" if held.tape and held.tape.replays else ""
        emit(Note, step=_STEP, text=f"{role} of station {held.station.model.id}{replay}")
        with _connect(rig):
            with rig.person():
                file, reads = held.station.document.name, held.tape is None
                before = check_left(rig, held.marks, person, file, reads=reads)
            if held.marks is not None:
                roles = held.marks.roles & needed
                before = (*before, *unguarded(held.station, held.registry, roles))
            for interference in (*before, *without_time_limits(held.station)):
                emit(
                    Intervention,
                    action=interference.action,
                    by=interference.by,
                    reason=interference.reason,
                    subject=interference.subject,
                )
            if held.marks is not None:
                held.marks.describe(run=str(log.absolute()))
                held.marks.put_on_record()
            guard = Guard(held.interlocks, rig, emit)
            session = Session(rig, emit, UnattendedAnswers(), stop, guard)
            jog = Jog(held, role, rig, session)
            try:
                yield jog
                jog.safe()
            except BaseException as error:
                _end_safe(jog, error)
                raise
            if jog.unsafe:
                raise DeviceError(f"the rig is not safe: {jog.unsafe}")


@contextmanager
def _connect(rig: Rig) -> Iterator[None]:
    """Connect the rig and make it safe at the end, unless a person asked to leave it as it is."""
    rig.connect()
    try:
        yield
    except LeftAsItStandsError:
        rig.close()
        raise
    except BaseException as error:
        rig.__exit__(type(error), error, error.__traceback__)
        raise
    rig.__exit__(None, None, None)


def _end_safe(jog: Jog, error: BaseException) -> None:
    """Make the rig safe after an error, which is reported first, with what is not safe.

    A stop or a failure of the log becomes a DeviceError if the rig is not safe, so that the end is
    not taken for a safe one.
    """
    with suppress(RigrunnerError):  # a failing log is reported by `error`
        jog.safe()
    if not jog.unsafe:
        return
    text = f"the rig is not safe: {jog.unsafe}"
    if isinstance(error, KeyboardInterrupt) or (
        isinstance(error, RigrunnerError) and not isinstance(error, DeviceError)
    ):
        raise DeviceError(f"{error_line(error)}; {text}") from error
    error.add_note(text)


@contextmanager
def _open_log(log: Path) -> Iterator[EventSink]:
    with _log_errors(log):
        sink = RunLog(log)

    def write(event: Event) -> None:
        with _log_errors(log):
            sink(event)

    with sink:
        yield write


@contextmanager
def _log_errors(log: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise DataError(
            f"cannot write the log {log}: {error.strerror or error}",
            hint="manual actions must be recorded; name another file with --log",
        ) from error


def _needed_roles(ready: ReadyStation, role: str) -> set[str]:
    """Return the role, and those that its limits and all interlocks read."""
    interlock_roles = {interlock.member.role for interlock in ready.interlocks}
    combinations = ready.station.model.safety.combinations
    groups = [{drive.role for drive in combination.drives} for combination in combinations]
    return {role, *interlock_roles}.union(*(group for group in groups if role in group))


def _lookup(what: str, name: str, entries: Mapping[str, _T]) -> _T:
    if name not in entries:
        hint = suggestion(name, entries, "there are")
        raise UsageError(f"there is no {what} '{name}'", hint=hint)
    return entries[name]
