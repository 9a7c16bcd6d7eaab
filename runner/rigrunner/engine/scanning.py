"""A scan: one step in which a drive goes through set-points, and each point is a row of a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, DeviceError
from rigrunner.api.events import Scanned
from rigrunner.engine.found import NONE, Measured, by_role
from rigrunner.engine.limits import clear_ranges, missed_text, remarks_on
from rigrunner.engine.moving import set_drive, wait
from rigrunner.plan.actions import SetDrive

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rigrunner.engine.session import Session
    from rigrunner.plan.actions import Scan


def scan(path: str, action: Scan, session: Session) -> Measured:
    """Do all points, each on record before the next begins; return the values of the last one.

    Between two points is what there is between two steps: the run can be stopped or paused there,
    and all interlocks are read. The first row out of limits ends it where the procedure says so,
    and is named in what is returned. Raises what the devices raise, with the set-point.
    """
    emit = session.emit.__call__  # a method is called more quickly than an object that has it
    member, others, table = action.member, action.setpoints, action.name
    settle_s, check, clear = action.settle_s, session.checker(), clear_ranges(action.limits)
    move, read = _mover(action, session), _reader(action, session)
    values: Mapping[str, float] = NONE
    for point, value in enumerate(action.values):
        try:
            if point:
                check()
            move(value)
            if settle_s:
                wait(settle_s, session)
            values = read()
        except (DeviceError, DataError) as error:
            error.message = f"at {where_at(action, point)}: {error.message}"
            raise
        row = {
            "seq": 0,
            "monotonic_s": 0.0,
            "utc": "",
            "step": path,
            "point": point,
            "measurement": table,
            "setpoints": {**others, member: value},
            "values": values,
        }
        emit(Scanned, row)
        for name, least, greatest in clear:  # written out: there may be thousands in a second
            if not least <= values[name] <= greatest:
                missed = _told(path, action, point, values, session)
                if missed and action.stops_at_limit:
                    return Measured(values, action.units, NONE, missed=missed)
                break
    return Measured(values, action.units, NONE)


def _told(
    path: str, action: Scan, point: int, values: Mapping[str, float], session: Session
) -> str:
    """Put the remarks on a row on record; return what of it is out of limits, in words."""
    remarks = list(remarks_on(action.limits, values, f"at {where_at(action, point)}: "))
    for kind, text in remarks:
        session.emit(kind, step=path, text=text)
    return missed_text(remarks)


def where_at(action: Scan, point: int) -> str:
    """Return 'press.load 20 N (point 2 of 10)'."""
    unit, number = action.units[action.member], f"point {point + 1} of {len(action.values)}"
    return f"{action.member} {action.values[point]:g} {unit} ({number})"


def _mover(action: Scan, session: Session) -> Callable[[float], object]:
    """Return what brings the drive to a set-point: at once, or led where the station says so."""
    role, drive = action.role, action.drive
    if session.rig.led_rate_per_s(role, drive) is None:
        return session.setter(role, drive)
    unit = action.units[action.member]
    return lambda value: set_drive(SetDrive(role, drive, value, unit), session)


def _reader(action: Scan, session: Session) -> Callable[[], Mapping[str, float]]:
    """Return what reads the channels, in their order."""
    rig, devices, names = session.rig, by_role(action.channels), action.channels
    if len(devices) == 1:
        ((role, channels),) = devices
        return rig.reader(role, channels)

    def read() -> Mapping[str, float]:
        found: dict[str, float] = {}
        for role, channels in devices:
            found |= rig.read(role, channels)
        return {name: found[name] for name in names}

    return read
