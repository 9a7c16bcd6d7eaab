"""Report on the devices of a station: identity, calibration, safety and speed."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

from rigrunner.api.devices import Readable, Settable
from rigrunner.api.errors import RigrunnerError
from rigrunner.api.member import Member
from rigrunner.rig import agrees

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.devices import Device, Identity
    from rigrunner.rig import Rig
    from rigrunner.tools.by_hand.station import ReadyStation

State = Literal["ok", "warn", "fail"]


@dataclass(frozen=True)
class DeviceIdentity:
    """The answer to the identity query of a role, or of a part of it."""

    maker: str
    model: str
    serial: str
    firmware: str
    simulated: bool


@dataclass(frozen=True)
class CalibrationStatus:
    """The calibration of a channel's instrument, from the register."""

    channel: str
    instrument: str
    state: State
    text: str


@dataclass(frozen=True)
class DriveStatus:
    """Where a drive is, in SI units."""

    drive: str
    unit: str
    found: float
    safe_value: float
    safe: bool


@dataclass(frozen=True, kw_only=True)
class DeviceReport:
    """The report on one device."""

    role: str
    plugin: str
    connected: bool = False
    who: Mapping[str, DeviceIdentity] = field(default_factory=dict)
    """By role, and by 'role/part' for each part of a composite device."""
    calibrated: tuple[CalibrationStatus, ...] = ()
    drives: tuple[DriveStatus, ...] = ()
    """The drives as they were before the device was made safe."""
    values: Mapping[str, float] = field(default_factory=dict)
    """Value of each readable channel, in SI units."""
    units: Mapping[str, str] = field(default_factory=dict)
    read_s: float | None = None
    """How long it took to read all of them once, in s."""
    problems: tuple[str, ...] = ()
    hint: str = ""

    @property
    def state(self) -> State:
        """`fail` if the device does not work as declared, `warn` if a person has to look."""
        if self.problems:
            return "fail"
        unsafe = any(not drive.safe for drive in self.drives)
        overdue = any(calibration.state != "ok" for calibration in self.calibrated)
        return "warn" if unsafe or overdue else "ok"

    def with_failure(self, error: Exception) -> DeviceReport:
        """Return the report with a further failure."""
        if isinstance(error, RigrunnerError):
            return replace(
                self, problems=(*self.problems, error.message), hint=self.hint or error.hint
            )
        text = f"{type(error).__name__}: {error}"
        return replace(self, problems=(*self.problems, f"a bug of the plugin: {text}"))


def device_reports(ready: ReadyStation) -> Iterator[DeviceReport]:
    """Yield the report of each device, connected alone, made safe and closed.

    Failures are in the report of their device, and do not keep others from being checked.
    """
    for role in ready.devices:
        yield _report_on(ready, role)


def _report_on(ready: ReadyStation, role: str) -> DeviceReport:
    rig, device = ready.rig([role]), ready.devices[role]
    plugin = ready.station.model.devices[role].plugin
    report = DeviceReport(role=role, plugin=plugin, calibrated=tuple(_calibrations(ready, role)))
    try:
        identity = rig.connect()[role]
    except Exception as error:  # noqa: BLE001  (a plugin may raise anything)
        return report.with_failure(error)
    report = replace(report, connected=True, who=dict(_identities(role, identity)))
    try:
        for extend in (_with_drives, _with_values):
            report = extend(report, rig, device)
    except BaseException as error:  # Ctrl-C: the device must not stay connected
        rig.__exit__(type(error), error, None)
        raise
    unsafe = [text for safety in rig.make_safe() if not safety.drive for text in safety.problems]
    report = replace(report, problems=(*report.problems, *(f"NOT SAFE: {t}" for t in unsafe)))
    try:
        rig.close()
    except Exception as error:  # noqa: BLE001  (the next device has its turn)
        return report.with_failure(error)
    return report


def _with_drives(report: DeviceReport, rig: Rig, device: Device) -> DeviceReport:
    if not isinstance(device, Settable):
        return report
    statuses: list[DriveStatus] = []
    for info in device.drives:
        try:
            read_back = rig.read_back(report.role, info.name)
        except Exception as error:  # noqa: BLE001  (the next drive has its turn)
            report = report.with_failure(error)
            continue
        safe = agrees(info, read_back, info.safe_value)
        statuses.append(DriveStatus(info.name, info.unit, read_back, info.safe_value, safe))
    return replace(report, drives=tuple(statuses))


def _with_values(report: DeviceReport, rig: Rig, device: Device) -> DeviceReport:
    if not isinstance(device, Readable):
        return report
    units = {info.name: info.unit for info in device.channels}
    began_s = time.perf_counter()
    try:
        values = rig.read(report.role, tuple(units))
    except Exception as error:  # noqa: BLE001  (it is still to be made safe)
        return report.with_failure(error)
    read_s = time.perf_counter() - began_s
    by_member: dict[str, str] = {Member(report.role, name): units[name] for name in units}
    return replace(report, values=values, units=by_member, read_s=read_s)


def _identities(role: str, identity: Identity) -> Iterator[tuple[str, DeviceIdentity]]:
    fields = (identity.maker, identity.model, identity.serial, identity.firmware)
    yield role, DeviceIdentity(*fields, simulated=identity.simulated)
    for name, part in identity.parts.items():
        yield from _identities(f"{role}/{name}", part)


def _calibrations(ready: ReadyStation, role: str) -> Iterator[CalibrationStatus]:
    state: State
    today = ready.clock.utc().date()
    register = ready.station.register
    binding = ready.station.model.devices[role]
    simulated = ready.registry.is_simulated(binding.plugin, binding.settings)
    for info in ready.devices[role].channels:
        channel = Member(role, info.name)
        if channel not in register:
            if not simulated:
                yield CalibrationStatus(channel, "", "ok", "not in the register")
            continue
        instrument, state = register[channel], "ok"
        text = f"calibrated until {instrument.due}"
        if instrument.calibration is not None:
            text = f"not calibrated: {instrument.calibration}"
        elif instrument.due is None:
            state, text = "warn", "no date of the next calibration is in the register"
        elif instrument.due < today:
            state, text = "warn", f"overdue since {instrument.due}"
        yield CalibrationStatus(channel, instrument.name, state, text)
