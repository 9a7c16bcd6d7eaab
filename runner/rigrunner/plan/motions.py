"""The steps that move something, or wait for it: set, ramp, settle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.units import rate_of, unit, units_of
from rigrunner.plan.actions import Ramp, SetDrive, Settle, Wait
from rigrunner.plan.terms import tried_terms

if TYPE_CHECKING:
    from rigrunner.api.devices import DriveInfo
    from rigrunner.api.member import Member
    from rigrunner.api.quantity import Quantity
    from rigrunner.plan.draft import Place, Scene
    from rigrunner.procedure import doings
    from rigrunner.yamlfile.document import Path

_ROUNDING = 1 + 1e-9


def plan_set(targets: doings.Set, place: Place, scene: Scene) -> None:
    """Write down that drives get set-points, one after the other."""
    for member, quantity in targets.drives.items():
        at = place.inside(member)
        drive = scene.drives.resolve(member, quantity, at.path, at.path, key=True)
        if drive is not None:
            seconds = scene.drives.move(member, drive, quantity.si)
            terms = tried_terms(targets, place, seconds, scene)
            scene.emit(at, *_set(member, quantity, drive), seconds, terms)


def plan_set_point(
    member: Member, quantity: Quantity, index: int, place: Place, scene: Scene
) -> None:
    """Write down that the drive of a sweep gets its next set-point."""
    named_at, valued_at = (*place.path, "set"), (*place.path, "over", index)
    drive = scene.drives.resolve(member, quantity, named_at, valued_at, key=False)
    if drive is not None:
        seconds = scene.drives.move(member, drive, quantity.si)
        at = place.time(index).inside("set")
        scene.emit(at, *_set(member, quantity, drive), seconds)


def plan_ramp(ramp: doings.Ramp, place: Place, scene: Scene) -> None:
    """Write down that a drive is led from one set-point to another."""
    drive = _resolved(ramp, "to", ramp.to, place, scene)
    if drive is None or (ramp.from_ and not _resolved(ramp, "from", ramp.from_, place, scene)):
        return
    start = ramp.from_.si if ramp.from_ else scene.drives.standing(ramp.drive, drive)
    before_s = scene.drives.move(ramp.drive, drive, start)
    duration_s = _ramp_s(ramp, abs(ramp.to.si - start), drive, place, scene)
    scene.drives.move(ramp.drive, drive, ramp.to.si)
    action = Ramp(ramp.drive.role, ramp.drive.name, start, ramp.to.si, drive.unit, duration_s)
    terms = tried_terms(ramp, place, before_s + duration_s, scene)
    text = f"Ramp {ramp.drive} to {ramp.to} in {duration_s:.3g} s"
    scene.emit(place, action, text, before_s + duration_s, terms)


def _resolved(
    ramp: doings.Ramp, end: str, quantity: Quantity, place: Place, scene: Scene
) -> DriveInfo | None:
    named_at, valued_at = (*place.path, "drive"), (*place.path, end)
    return scene.drives.resolve(ramp.drive, quantity, named_at, valued_at, key=False)


def plan_settle(settle: doings.Settle, place: Place, scene: Scene) -> None:
    """Write down that the motion is given time."""
    if settle.time is not None:
        text = f"Settle for {settle.time:.3g} s"
        scene.emit(place, Settle(settle.time), text, settle.time)
        return
    frequency_hz = scene.drives.cycle_frequency_hz(None, (*place.path, "cycles"))
    if frequency_hz and settle.cycles:
        seconds = settle.cycles / frequency_hz
        text = f"Settle for {settle.cycles} cycles ({seconds:.3g} s)"
        scene.emit(place, Settle(seconds), text, seconds)


def plan_wait(wait: doings.Wait, place: Place, scene: Scene) -> None:
    """Write down that time passes."""
    text = f"Wait for {wait.time:.3g} s"
    whole = f"{text}: {wait.text}" if wait.text else text
    scene.emit(place, Wait(wait.time), whole, wait.time)


def _set(member: Member, quantity: Quantity, drive: DriveInfo) -> tuple[SetDrive, str]:
    action = SetDrive(member.role, member.name, quantity.si, drive.unit)
    return action, f"Set {member} to {quantity}"


def _ramp_s(
    ramp: doings.Ramp, distance: float, drive: DriveInfo, place: Place, scene: Scene
) -> float:
    """Return how long the ramp takes; one that the drive cannot follow is a problem."""
    if ramp.rate is not None:
        at: Path = (*place.path, "rate")
        seconds = distance / _rate(ramp.drive, ramp.rate, drive, at, scene)
    else:
        seconds, at = ramp.time or 0.0, (*place.path, "time")
    fastest = drive.rate_per_s
    if fastest and seconds and distance > fastest * seconds * _ROUNDING:
        message = f"{ramp.drive} moves by {fastest:g} {drive.unit} in a second at most"
        hint = f"it needs {distance / fastest:.3g} s for this ramp"
        scene.complain(at, message, hint)
    return seconds


def _rate(member: Member, rate: Quantity, drive: DriveInfo, at: Path, scene: Scene) -> float:
    """Return a rate in SI units per second; endless where there is a problem with it."""
    dimension = unit(drive.unit).dimension
    wanted = rate_of(dimension)
    if wanted is None:
        scene.complain(at, f"there is no unit for the rate of a {dimension}", "give a time")
    elif rate.dimension != wanted:
        message = f"got '{rate}', a {rate.dimension}; {member} takes a {wanted}"
        scene.complain(at, message, f"write it in {' or '.join(units_of(wanted))}")
    elif rate.si <= 0:
        scene.complain(at, f"got '{rate}', allowed is more than 0")
    else:
        return rate.si
    return float("inf")
