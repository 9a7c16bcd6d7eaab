"""What the guardian does after its owner: it makes the rig safe and reports that everywhere."""

from __future__ import annotations

import os
import time
from contextlib import ExitStack, contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from threading import TIMEOUT_MAX, Thread
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DeviceError
from rigrunner.api.events import Alarm, MadeSafe
from rigrunner.api.member import role_of
from rigrunner.bus import EventStamp
from rigrunner.clock import WallClock, utc_text
from rigrunner.registry import load_registry
from rigrunner.rig import Rig, unsafe_text
from rigrunner.rig_state import (
    Busy,
    Holder,
    Marker,
    hold,
    read_marker,
    record_made_safe,
    shared_folder,
    take_over,
)
from rigrunner.run.guardian.saying import say
from rigrunner.run.lab_plugins import with_lab_plugins
from rigrunner.run.log import with_units
from rigrunner.run.prepare import make_devices, patience_of
from rigrunner.station import parse_station

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.rig import SafetyReport

ATTEMPTS = 4
"""Number of attempts: a port may become free only seconds after its process has died."""
PAUSE_S = 2.0
ATTEMPT_S = 900.0
"""Time limit of an attempt, beyond the time that its drives need."""
NOTE_FILE = "guardian.txt"
"""In the folder of the run: what the guardian found and did."""


def act(task: dict[str, Any], reason: str) -> None:
    """Make the rig safe if it is energised and nobody else has taken it, and report the result."""
    station = task["station"]
    lock_is_there = os.path.exists(task["locks"][0])  # noqa: PTH110  (False where that is unknown)
    try:
        with _rig_held(task):
            marker = read_marker(station)
            if marker is None and not lock_is_there:  # somebody has removed the marker too
                marker = Marker(station, None)
            if marker is None or marker.safe_by:
                say(f"{reason}; the rig was not energised")
                return
            _make_safe(task, marker, reason)
    except Busy as busy:
        who = f" ({busy.holder.procedure}, process {busy.holder.process})" if busy.holder else ""
        say(f"{reason}; another process has taken the rig{who}: it is left alone")
    except Exception as error:  # noqa: BLE001  (nothing else can report it)
        say(f"{reason}. THE RIG IS NOT SAFE: {type(error).__name__}: {error}. Go to the rig.")
        _note(task, [f"{reason}; the rig could not be made safe: {type(error).__name__}: {error}"])


@contextmanager
def _rig_held(task: dict[str, Any]) -> Iterator[None]:
    """Hold the rig by the inherited locks, so that no other process can take it, or by new ones."""
    now = utc_text(datetime.now(UTC))
    what = f"the guardian of {task['what']}, which makes the rig safe"
    holder = Holder(task["station"], what, os.getpid(), now)
    paths = [Path(path) for path in task["locks"]]
    handed = task["handed"]
    with ExitStack() as stack:
        # A rig that cannot be locked is made safe too: its disk may be full, broken or read-only.
        with suppress(DeviceError):
            shared_folder()
        with suppress(OSError):
            held = take_over(handed, paths, holder) if handed else hold(paths, holder)
            stack.enter_context(held)
        yield


def _make_safe(task: dict[str, Any], marker: Marker, reason: str) -> None:
    say(f"{reason}; last set-points: {marker.set_points}. Making the rig safe.")
    reports: tuple[SafetyReport, ...] = ()
    problem = ""
    for attempt in range(ATTEMPTS):
        time.sleep(attempt * PAUSE_S)
        reports, problem = _limited_attempt(task)
        if not problem:
            break
    skipped = [role for role in task["unreachable"] if _has_drive_of(marker, role)]
    if skipped:
        names = ", ".join(skipped)
        unreachable = f"{names}: its plugin says that no second process can open it"
        problem = "; ".join(text for text in (problem, unreachable) if text)
    if not problem:
        # First: the next start reads the marker, even if the notes cannot be written. Without its
        # record it makes the rig safe again.
        with suppress(DeviceError, OSError):
            record_made_safe(task["station"], "The guardian made it safe")
    lines = [f"{reason}; last set-points: {marker.set_points}", *_lines(reports, problem)]
    for line in lines[1:]:
        say(line)
    _note(task, lines)
    run = marker.owner.run if marker.owner is not None else ""
    if run and Path(run).is_dir():
        with suppress(Exception):  # the other reports have it too
            _write_events(Path(run), lines[0], reports, problem)


def _limited_attempt(task: dict[str, Any]) -> tuple[tuple[SafetyReport, ...], str]:
    """Return the result of an attempt; a driver that is called inline may never return."""
    results: list[tuple[tuple[SafetyReport, ...], str]] = []
    errors: list[BaseException] = []
    needed_s: list[float] = []

    def attempt() -> None:
        try:
            results.append(_one_attempt(task, needed_s.append))
        except BaseException as error:  # noqa: BLE001  (reported: nothing else can)
            errors.append(error)

    thread = Thread(target=attempt, daemon=True)
    thread.start()
    # In two parts: what the drives need is known only once the devices are made.
    thread.join(ATTEMPT_S)
    limit_s = min(ATTEMPT_S + sum(needed_s), TIMEOUT_MAX)
    thread.join(limit_s - ATTEMPT_S)
    if results:
        return results[0]
    if errors:
        return (), f"{type(errors[0]).__name__}: {errors[0]}"
    return (), f"a device did not return within {limit_s:g} s"


def _one_attempt(
    task: dict[str, Any], need: Callable[[float], None]
) -> tuple[tuple[SafetyReport, ...], str]:
    """Make and connect each device, make it safe; return what is not safe, as text.

    Calls `need` with the time in s that the drives may take to their safe values.
    """
    file = Path(task["station_file"])
    # The text with which the run began: the file may have been edited since.
    station = parse_station(task["station_text"], str(file))
    registry = with_lab_plugins(load_registry(), station, file.parent)
    clock = WallClock()
    all_devices = make_devices(station, registry, clock, file.parent)
    devices = {role: device for role, device in all_devices.items() if role in task["roles"]}
    with suppress(Exception):  # a device that cannot list its drives is made safe too
        need(sum(info.longest_s for device in devices.values() for info in device.drives))
    order = [member for member in station.model.safety.order if role_of(member) in devices]
    rig = Rig(devices, clock, patience_of(station), order)
    failed = rig.connect_each()
    try:
        reports = rig.make_safe()
    finally:
        with suppress(Exception):
            rig.close()
    unsafe = unsafe_text(reports)
    unreached = "; ".join(f"{role} was not reached: {text}" for role, text in failed.items())
    return reports, "; ".join(text for text in (unreached, unsafe) if text)


def _has_drive_of(marker: Marker, role: str) -> bool:
    """Return whether a drive of a device may be energised; of an unreadable marker each may be."""
    is_readable = marker.owner is not None
    return not is_readable or any(drive.member.role == role for drive in marker.drives)


def _lines(reports: tuple[SafetyReport, ...], problem: str) -> list[str]:
    lines = [
        f"{report.what} is safe: read back {with_units(report.read_back, report.units)}"
        for report in reports
        if report.safe and report.read_back
    ]
    if problem:
        return [*lines, f"THE RIG IS NOT SAFE: {problem}. Go to the rig."]
    return [*lines, "the rig is safe: every drive was read back at its safe value"]


def _note(task: dict[str, Any], lines: list[str]) -> None:
    """Add to the log of the rig, and to a file beside it."""
    marker = read_marker(task["station"])
    run = marker.owner.run if marker is not None and marker.owner is not None else ""
    logs = [Path(run)] if run else []  # of manual mode
    if run and Path(run).is_dir():
        logs = [Path(run) / "run.log", Path(run) / NOTE_FILE]
    now = utc_text(datetime.now(UTC))
    text = "".join(f"{now} ALARM guardian: {line}\n" for line in lines)
    for log in logs:
        with suppress(OSError), log.open("ab") as file:
            file.write(text.encode(errors="replace"))


def _write_events(folder: Path, what: str, reports: tuple[SafetyReport, ...], problem: str) -> None:
    """Record in the run how its rig was left, for those who resume or recover it."""
    from rigrunner.run.interrupted import next_seq, read_interrupted  # noqa: PLC0415  (as above)
    from rigrunner.runfile import RunWriter, run_lock  # noqa: PLC0415  (numpy: the rig is first)

    with run_lock(folder):
        stored = read_interrupted(folder)
        stamp = EventStamp(WallClock(), next_seq(stored))
        with RunWriter(folder) as writer:
            writer(stamp(Alarm, source="guardian", text=what))
            for report in reports:
                made_safe = stamp(
                    MadeSafe,
                    what=report.what,
                    read_back=report.by_member(report.read_back),
                    units=report.by_member(report.units),
                    problems=report.problems,
                )
                writer(made_safe)
            if problem:
                writer(stamp(Alarm, source="guardian", text=f"the rig is not safe: {problem}"))
