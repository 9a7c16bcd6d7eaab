"""The manual page: set a drive, watch, record a point."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.units import unit
from rigrunner_panel.errors import PanelError, not_found, wrong_state
from rigrunner_panel.process import messages
from rigrunner_panel.web.answers import Done
from rigrunner_panel.web.running import start_job

if TYPE_CHECKING:
    from rigrunner_panel.view.manual import DriveView, ManualView
    from rigrunner_panel.web.operation import ApiRequest
    from rigrunner_panel.web.panel import Rig
    from rigrunner_panel.web.requests import RecordPoint, SetDrive


def open_manual(rig: Rig, request: ApiRequest) -> Done:
    """Let a person have the rig, after a preflight as for a run."""
    start_job(rig, "manual", request.body, request.by)
    return Done()


def set_drive(rig: Rig, request: ApiRequest) -> Done:
    """Set a drive within its limits."""
    body: SetDrive = request.body
    drive = _drive(rig, body.drive)
    value = _value(drive, body.value)
    if not drive.minimum <= value <= drive.maximum:
        limits = f"{drive.minimum:g} to {drive.maximum:g} {drive.unit}"
        raise PanelError(422, "invalid", f"{body.value} is out of range ({limits})")
    rig.desk.by_hand(messages.SetDrive(drive.name, value, request.by))
    return Done()


def record_point(rig: Rig, request: ApiRequest) -> Done:
    """Record a point where the rig is."""
    body: RecordPoint = request.body
    rig.desk.by_hand(messages.RecordPoint(body.cycles, request.by))
    return Done()


def close_manual(rig: Rig, request: ApiRequest) -> Done:
    """Make the rig safe, and seal what was recorded."""
    rig.desk.by_hand(messages.CloseManual(request.by))
    return Done()


def _drive(rig: Rig, name: str) -> DriveView:
    view: ManualView | None = rig.board.get("manual")
    if view is None:
        raise wrong_state("manual mode is not connected to the rig", "open it first")
    for drive in view.drives:
        if drive.name == name:
            return drive
    raise not_found(f"there is no drive '{name}'", ", ".join(drive.name for drive in view.drives))


def _value(drive: DriveView, text: str) -> float:
    """Return a set-point in the drive's SI unit; raise PanelError for what is none."""
    try:
        return parse_quantity(text, unit(drive.unit).dimension).si
    except RigrunnerError as error:
        raise PanelError(422, "invalid", error.message, error.hint) from error
