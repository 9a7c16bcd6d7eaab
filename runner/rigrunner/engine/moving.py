"""Drives on their way: set at once, or led from set-point to set-point; and time that passes."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING

from rigrunner.engine.found import NONE, Measured
from rigrunner.plan.actions import Ramp, SetDrive

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.engine.session import Session

_NAP_S = 0.1
"""How long a wait goes on before the stop token is looked at again."""
_MOST_RAMP_STEPS = 1000


def set_drive(action: SetDrive, session: Session) -> Measured:
    """Bring a drive to its set-point: at once, or led there where the station says how fast."""
    session.check()
    rate_per_s = session.rig.led_rate_per_s(action.role, action.drive)
    if rate_per_s is None:
        actual = session.set(action.role, action.drive, action.value)
        return Measured({action.member: actual}, {action.member: action.unit}, NONE)
    start = session.rig.standing(action.role, action.drive)
    seconds = abs(action.value - start) / rate_per_s
    return ramp(Ramp(action.role, action.drive, start, action.value, action.unit, seconds), session)


def ramp(action: Ramp, session: Session) -> Measured:
    """Set the drive again and again, so that it stays on the line from start to end."""
    actual = session.set(action.role, action.drive, action.start)
    clock = session.rig.clock
    began_s = clock.monotonic_s()
    steps = min(max(ceil(action.duration_s / _NAP_S), 1), _MOST_RAMP_STEPS)
    for step in range(1, steps + 1):
        share = step / steps
        value = action.start + share * (action.end - action.start)
        actual = session.set(action.role, action.drive, value)
        session.check()
        wait(began_s + share * action.duration_s - clock.monotonic_s(), session)
    return Measured({action.member: actual}, {action.member: action.unit}, NONE)


def naps(duration_s: float, session: Session) -> Iterator[None]:
    """Yield while a time passes, often enough for the stop token to be looked at."""
    clock = session.rig.clock
    until_s = clock.monotonic_s() + duration_s
    while (left_s := until_s - clock.monotonic_s()) > 0:
        session.check()
        yield
        clock.sleep(min(left_s, _NAP_S))


def wait(duration_s: float, session: Session) -> None:
    """Let a time pass; raise what keeps the step from going on."""
    for _ in naps(duration_s, session):
        pass
