"""Checks with the devices: their identity, their zero readings, and the interlocks."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial
from threading import Event
from typing import TYPE_CHECKING

from rigrunner.api.devices import Readable
from rigrunner.api.errors import RigrunnerError
from rigrunner.api.member import Member, role_of
from rigrunner.rig import Patience, Rig, unsafe_text
from rigrunner.run.left_energised import settle_by, standing_of, what_to_do
from rigrunner.run.log import with_units
from rigrunner.steps.zero import Zero
from rigrunner_panel.view.sections import PreflightItem

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.devices import Identity
    from rigrunner.plan.actions import Interlock
    from rigrunner.rig_state import RigMarks
    from rigrunner.run.prepare import Planned
    from rigrunner_panel.process.messages import Job

_LOOK_S = 0.5
"""Longest time in s for checking a zero; the run takes its own time."""


def rig_items(planned: Planned, marks: RigMarks | None = None) -> Iterator[PreflightItem]:
    """Connect each device by itself, check it, make it safe and close it."""
    safety = planned.station.model.safety
    patience = Patience(safety.patience.connect, safety.patience.answer)
    if marks is not None and marks.left is not None:
        fix = "each drive is made safe here before anything else; see the items below"
        text = marks.left.text
        yield PreflightItem(kind="device", name="rig", state="warn", text=text, fix=fix)
    with ExitStack() as cleanup:
        rigs: dict[str, Rig] = {}
        for role, device in planned.devices.items():
            rig = Rig({role: device}, planned.clock, patience, marks=marks)
            try:
                identity = rig.connect()[role]
            except RigrunnerError as error:
                fix = error.hint or "check its power, its cable and its settings in the station"
                text = error.message
                yield PreflightItem(kind="device", name=role, state="fail", text=text, fix=fix)
                continue
            # Done backwards at the end: each rig is made safe, and closed after that.
            cleanup.callback(rig.close)
            cleanup.callback(rig.make_safe)
            rigs[role] = rig
            yield _connected_item(role, identity)
        if marks is not None:
            for role in sorted(marks.roles & rigs.keys(), key=partial(_position, safety.order)):
                yield from _energised_items(role, rigs[role])
        yield from _interlock_items(planned, rigs)
        yield from _zero_items(planned, rigs)


def _connected_item(role: str, identity: Identity) -> PreflightItem:
    text = " ".join(
        part
        for part in (identity.maker, identity.model, identity.serial, identity.firmware)
        if part
    )
    simulated = " (simulated)" if identity.simulated else ""
    return PreflightItem(kind="device", name=role, state="ok", text=f"{text}{simulated}")


def unconfirmed_item(marks: RigMarks, station_file: str, job: Job) -> PreflightItem:
    """Report devices that were not read back as safe, unless a person confirmed them."""
    common = {"kind": "device", "name": "rig"}
    text = f"not read back as safe since then: {', '.join(sorted(marks.unconfirmed))}"
    if job.reason:
        settle_by(marks, job.by, job.reason)
        fix = f"{job.by} says that it is safe: {job.reason}"
        return PreflightItem(**common, state="warn", text=text, fix=fix)
    return PreflightItem(
        **common, state="fail", text=text, fix=what_to_do(station_file), asks_safe=True
    )


def _position(order: Sequence[Member | str], role: str) -> int:
    """Return the position of a device in the station's make-safe order."""
    roles = [role_of(member) for member in order]
    return roles.index(role) if role in roles else len(roles)


def _energised_items(role: str, rig: Rig) -> Iterator[PreflightItem]:
    """Report drives of a device that were not in their safe state, and make it safe at once."""
    energised = [drive.text for drive in standing_of(rig, [role]) if not drive.is_safe]
    reports = rig.make_safe()
    if problem := unsafe_text(reports):
        text = "; ".join((*energised, f"it could not be made safe: {problem}"))
        fix = "switch it off manually before anyone touches the rig"
        yield PreflightItem(kind="device", name=role, state="fail", text=text, fix=fix)
    elif energised:
        readings = ", ".join(
            with_units(report.read_back, report.units) for report in reports if report.read_back
        )
        text = f"found energised: {'; '.join(energised)}; made safe, read back now: {readings}"
        fix = "find out why it was left on before anyone touches the rig"
        yield PreflightItem(kind="device", name=role, state="warn", text=text, fix=fix)


def _interlock_items(planned: Planned, rigs: dict[str, Rig]) -> Iterator[PreflightItem]:
    for interlock in planned.plan.interlocks:
        role = interlock.member.role
        if role in rigs and isinstance(planned.devices[role], Readable):
            yield _interlock_item(interlock, rigs[role])


def _interlock_item(interlock: Interlock, rig: Rig) -> PreflightItem:
    override = f"interlock {interlock.name}" if interlock.overridable else ""
    common, member = {"kind": "interlock", "name": interlock.name}, interlock.member
    try:
        value = rig.read(member.role, (member.name,))[member]
    except RigrunnerError as error:
        text = f"{interlock.member} cannot be read: {error.message}"
        return PreflightItem(**common, state="fail", text=text, fix=error.hint, override=override)
    shown = interlock.shown
    reading = f"{interlock.member} is {(value - shown.offset) / shown.factor:.4g} {shown.symbol}"
    if interlock.minimum <= value <= interlock.maximum:
        return PreflightItem(**common, state="ok", text=reading)
    text = f"{reading}, {interlock.condition}"
    fix = f"clear it: otherwise the run will {interlock.does.replace('_', ' ')} at once"
    return PreflightItem(**common, state="fail", text=text, fix=fix, override=override)


def _zero_items(planned: Planned, rigs: dict[str, Rig]) -> Iterator[PreflightItem]:
    zeros = {
        step.action.zeroed: step.action
        for step in planned.plan.steps
        if isinstance(step.action, Zero)
    }
    for name, zero in zeros.items():
        if zero.role in rigs:
            yield _zero_item(name, zero, rigs[zero.role])


def _zero_item(name: str, zero: Zero, rig: Rig) -> PreflightItem:
    try:
        mean = _mean(zero, rig)
    except RigrunnerError as error:
        fix = error.hint or "check the device"
        return PreflightItem(kind="zero", name=name, state="fail", text=error.message, fix=fix)
    text = f"reads {mean:.4g} {zero.unit} at rest (limit: ±{zero.within:g} {zero.unit})"
    if abs(mean) <= zero.within:
        return PreflightItem(kind="zero", name=name, state="ok", text=text)
    fix = "is the rig at rest and unloaded? if so, adjust the instrument's zero"
    override = f"zero {name}"
    return PreflightItem(
        kind="zero", name=name, state="fail", text=text, fix=fix, override=override
    )


def _mean(zero: Zero, rig: Rig) -> float:
    duration_s = min(zero.duration_s, _LOOK_S)
    never_set = Event()
    blocks = rig.stream(zero.role, (zero.channel,), duration_s, never_set)
    values = [float(value) for block in blocks for value in block.channels[zero.channel]]
    if not values:
        raise RigrunnerError("no sample came")
    return sum(values) / len(values)
