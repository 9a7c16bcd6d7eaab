"""`rigrunner devices`: connect the devices, and report identity, calibration and safety."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from rigrunner.api.errors import ExitCode, UsageError
from rigrunner.api.quantity import legible
from rigrunner.api.summaries import pairs
from rigrunner.cli.completing import stations
from rigrunner.cli.options import json_option, record_option, replay_option
from rigrunner.cli.output import message, result, result_json
from rigrunner.run.locate import find_station

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.rig_state import RigMarks
    from rigrunner.tools.by_hand.devices import DeviceIdentity, DeviceReport

_MILLI = 1e3


@click.command(name="devices")
@click.argument("station", shell_complete=stations)
@record_option
@replay_option
@json_option
@click.option(
    "--safe-by",
    metavar="NAME",
    help="Who confirms that a rig that was left energised is safe.",
)
@click.option("--reason", default="", metavar="TEXT", help="What that person saw or did.")
def command(
    station: str,
    record: Path | None,
    replay: Path | None,
    *,
    as_json: bool,
    safe_by: str | None,
    reason: str,
) -> ExitCode:
    """Connect each device of a station, and report its identity and state.

    Each is connected separately, read once, made safe and closed. The exit code is 4 if one fails.
    A rig that was left energised is reported first. If a device cannot be read back, a person
    confirms its state with --safe-by and --reason.
    """
    from rigrunner.cli.output import warning_label
    from rigrunner.cli.stopping import stop_on_signals
    from rigrunner.run.taping import tape_for
    from rigrunner.tools.by_hand.devices import device_reports
    from rigrunner.tools.by_hand.station import ready_station

    if safe_by is not None and not (safe_by.strip() and reason.strip()):
        raise UsageError("--safe-by needs a name, and --reason what that person saw or did")
    tape = tape_for(record, replay)
    if replay is not None:
        message(f"Replaying the tape {replay}: no instrument is used.")
    reports: list[DeviceReport] = []
    prepared = ready_station(find_station(station), tape=tape)
    with stop_on_signals() as stop, prepared.hold("devices") as ready:
        if ready.marks is not None and ready.marks.left is not None:
            message(f"{warning_label()} {ready.marks.left.text}")
        for report in device_reports(ready):
            reports.append(report)
            if not as_json:
                result(f"{pairs(list(_rows(report)))}\n")
            if stop.is_set():  # this device was made safe and closed; the next one is not touched
                raise stop.reason()
        unconfirmed = _unconfirmed(ready.marks, station, safe_by, reason)
    failed = [report.role for report in reports if report.state == "fail"]
    if as_json:
        result_json([{"state": report.state, **asdict(report)} for report in reports])
    else:
        count = f"{len(reports)} device{'s' if len(reports) != 1 else ''}"
        if failed:
            result(f"{count}, of which {len(failed)} failed: {', '.join(failed)}")
        else:
            result(f"{count}: all answer and were made safe")
    for text in tape.notes() if tape else ():
        message(f"note: {text}")
    return ExitCode.DEVICE if failed or unconfirmed else ExitCode.PASS


def _unconfirmed(marks: RigMarks | None, station: str, safe_by: str | None, reason: str) -> bool:
    """Return whether a rig that was left energised is not confirmed safe, and report it."""
    from rigrunner.cli.output import warning_label
    from rigrunner.run.left_energised import settle_by, what_to_do

    if marks is None or not marks.unconfirmed:
        return False
    roles = ", ".join(sorted(marks.unconfirmed))
    if safe_by is not None:
        settle_by(marks, safe_by, reason)
        message(f"{safe_by.strip()} states that {roles} is safe; the next run records it.")
        return False
    message(f"{warning_label()} not read back as safe since the rig was left energised: {roles}")
    message(f"  {what_to_do(station)}")
    return True


def _rows(report: DeviceReport) -> Iterator[tuple[str, str]]:
    yield f"{report.state:4}  {report.role}", f"plugin {report.plugin}"
    for place, who in report.who.items():
        part = "" if place == report.role else f"part {place.removeprefix(f'{report.role}/')}: "
        yield "", f"{part}{_identity_text(who)}"
    if not report.connected:
        yield "", "not connected"
    for text in report.problems:
        yield "", f"problem: {text}"
    if report.hint:
        yield "", f"fix: {report.hint}"
    for drive in report.drives:
        at = f"{drive.drive} is at {legible(drive.found, drive.unit)}"
        safe = f"safe is {legible(drive.safe_value, drive.unit)}"
        yield "", f"{at}, which is safe" if drive.safe else f"{at}, NOT SAFE when found: {safe}"
    for name, value in report.values.items():
        yield "", f"{name.partition('.')[2]} reads {legible(value, report.units[name])}"
    if report.read_s is not None:
        yield "", f"reading all of these once took {_MILLI * report.read_s:.3g} ms"
    for calibration in report.calibrated:
        instrument = f" by {calibration.instrument}" if calibration.instrument else ""
        fix = "; have it calibrated, or enter its certificate" if calibration.state != "ok" else ""
        yield "", f"{calibration.channel}{instrument}: {calibration.text}{fix}"


def _identity_text(who: DeviceIdentity) -> str:
    serial = f"serial {who.serial}" if who.serial else ""
    firmware = f"firmware {who.firmware}" if who.firmware else ""
    text = ", ".join(part for part in (f"{who.maker} {who.model}", serial, firmware) if part)
    return f"{text} (simulated)" if who.simulated else text
