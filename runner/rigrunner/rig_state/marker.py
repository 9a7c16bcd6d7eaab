"""The marker of an energised rig: its run and its last set-points; it survives the process.

A marker is a file that is not empty. It is written, and on the disk, before a drive is first set to
anything but its safe value, and emptied once all drives were read back at their safe values. Its
first `HEADER` bytes have the owner and the drives, as JSON. After them comes the last set-point of
each drive, as a double. An unreadable header means an energised rig too: the machine may have lost
power during the write, or its disk was full.
"""

from __future__ import annotations

import errno
import json
import math
import os
import struct
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DeviceError
from rigrunner.api.member import Member
from rigrunner.clock import utc_text
from rigrunner.rig_state.folder import (
    existing_folder,
    open_plain,
    read_plain,
    shared_folder,
    usable,
)
from rigrunner.rig_state.locks import holder_of, is_held

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

FORM = "energised/1"
SUFFIX = ".energised"
HEADER = 16384
"""Number of bytes before the set-points."""
VALUE = struct.Struct("<d")


@dataclass(frozen=True)
class Owner:
    """The process that energised a rig."""

    station: str
    """Id of the station."""
    station_file: str
    procedure: str
    """What it does: the id of the procedure, or words such as 'jog psu'."""
    process: int
    host: str
    since: str
    """When the rig was locked, in UTC."""
    run: str = ""
    """Folder of the run, or log of manual mode; '' for none."""
    guardian: str = ""
    """What makes the rig safe if the process dies; '' for nothing."""
    unguarded: str = ""
    """Devices that it cannot reach, as text."""
    addresses: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Addresses of the device in each role."""
    plugins: Mapping[str, str] = field(default_factory=dict)
    """Plugin of the device in each role."""


@dataclass(frozen=True)
class DriveMark:
    """A drive that was set to another value than its safe one."""

    member: Member
    unit: str
    safe_value: float
    set_point: float
    """The last set-point that was sent, in SI units; NaN if unknown."""

    def text(self) -> str:
        """Return 'psu.voltage 40 V'."""
        if math.isnan(self.set_point):
            return f"{self.member} at an unknown value"
        return f"{self.member} {self.set_point:g} {self.unit}".rstrip()


@dataclass(frozen=True)
class Marker:
    """A rig that was energised and has not been confirmed safe since."""

    station: str
    owner: Owner | None
    """None if the marker cannot be read."""
    drives: tuple[DriveMark, ...] = ()
    """Drives whose last set-point is not confirmed to be gone."""
    safe_by: str = ""
    """What made the rig safe after its run, and when; '' while it counts as energised."""
    is_in_use: bool = False
    """Whether the process that energised the rig still holds it."""

    @property
    def set_points(self) -> str:
        """The last set-points as text."""
        return ", ".join(drive.text() for drive in self.drives) or "set-points not known"

    @property
    def who(self) -> str:
        """Who energised the rig, as text."""
        if self.owner is None:
            return "a run whose marker cannot be read"
        kind = "log" if self.owner.procedure.startswith("jog ") else "run"
        where = f" ({kind} {self.run_name})" if self.owner.run else ""
        return f"{self.owner.procedure}{where}, process {self.owner.process}"

    @property
    def run_name(self) -> str:
        """The name of the run; '' for none."""
        return os.path.basename(self.owner.run) if self.owner else ""  # noqa: PTH119  (of any system)

    @property
    def text(self) -> str:
        """What a person must know before they touch the rig."""
        rig = f"the rig of station {self.station}"
        last = f"last set-points: {self.set_points}"
        since = f", begun {self.owner.since}" if self.owner else ""
        if self.safe_by:
            return f"{rig} was left energised by {self.who}{since}; {last}; {self.safe_by}"
        if self.is_in_use:
            return f"{rig} is energised by {self.who}{since}; {last}"
        if self.owner is None:
            return (
                f"{rig} may be energised: its marker cannot be read, as after a full disk or a"
                " power cut while it was written; nothing has confirmed since that it is safe"
            )
        unguarded = self.owner.unguarded
        return (
            f"{rig} was left energised by {self.who}{since}; {last};"
            f" nothing has confirmed since that it is safe{f'; {unguarded}' if unguarded else ''}"
        )


def read_marker(station: str) -> Marker | None:
    """Return the marker of the rig of a station; None if it was not left energised."""
    try:
        folder = existing_folder()
    except DeviceError:  # unreadable is not safe
        return Marker(station, None)
    return None if folder is None else _read(folder / f"{station}{SUFFIX}")


def read_marker_of_held(station: str, lock: Path) -> Marker | None:
    """Return the marker of a rig that is held by that lock file; None if it is not energised.

    Without the lock file somebody, or a cleaner of old files, has removed the marker too: then
    nothing is known of the drives.
    """
    is_there = os.path.exists(lock)  # noqa: PTH110  (False also where that is unknown)
    return read_marker(station) if is_there else Marker(station, None)


def read_markers() -> list[Marker]:
    """Return the markers of all rigs of this machine, by station; raise DeviceError."""
    folder = existing_folder()
    if folder is None:
        return []
    with usable(folder):
        paths = sorted(folder.glob(f"*{SUFFIX}"))
    markers = map(_read, paths)
    return [marker for marker in markers if marker is not None]


def clear(station: str) -> None:
    """Empty the marker of a rig whose drives were all read back as safe.

    The caller holds the rig. Raises OSError and DeviceError.
    """
    folder = existing_folder()
    if folder is None or not (path := folder / f"{station}{SUFFIX}").exists():
        return
    with _opened(path) as descriptor:
        os.ftruncate(descriptor, 0)
        os.fsync(descriptor)
    with suppress(OSError):  # it may be another user's: an empty file is no marker
        path.unlink()


def record_made_safe(station: str, by: str) -> None:
    """Record that the rig was made safe after its run and read back; shown at the next start.

    `by` is the actor as text, such as 'The guardian made it safe'. The caller holds the rig, or is
    the guardian of its owner. Raises OSError and DeviceError.
    """
    marker = read_marker(station)
    if marker is None:
        return
    if marker.owner is None:  # it has nothing to keep
        clear(station)
        return
    text = f"{by} at {utc_text(datetime.now(UTC))}"
    with _opened(shared_folder() / f"{station}{SUFFIX}") as descriptor:
        overwrite(descriptor, encode(marker.owner, marker.drives, text))


def encode(owner: Owner, drives: tuple[DriveMark, ...], safe_by: str = "") -> bytes:
    """Return the content of the file of a marker."""
    fields: dict[str, Any] = {
        "rigrunner": FORM,
        "owner": asdict(owner),
        "drives": [[drive.member, drive.unit, drive.safe_value] for drive in drives],
        "safe_by": safe_by,
    }
    header = json.dumps(fields, ensure_ascii=False).encode(errors="replace")
    # With very many drives: the set-points of all follow the header, which names as many as fit.
    if len(header) >= HEADER:
        fields["owner"] = asdict(replace(owner, addresses={}, plugins={}))
        fields["drives"] = fields["drives"][:100]
        header = json.dumps(fields, ensure_ascii=False).encode(errors="replace")
    values = b"".join(VALUE.pack(drive.set_point) for drive in drives)
    return header.ljust(HEADER) + values


def overwrite(descriptor: int, content: bytes) -> None:
    """Overwrite a marker and wait for the disk; it is never empty meanwhile."""
    os.lseek(descriptor, 0, os.SEEK_SET)
    if os.write(descriptor, content) != len(content):
        raise OSError(errno.ENOSPC, "the disk is full")
    os.ftruncate(descriptor, len(content))
    os.fsync(descriptor)


def decode(station: str, content: bytes) -> Marker:
    """Decode the file of a marker; without an owner if it cannot be read."""
    try:
        fields = json.loads(content[:HEADER])
        owner = Owner(**fields["owner"])
        drives = tuple(
            DriveMark(Member.parse(member), unit, safe, _value(content, index))
            for index, (member, unit, safe) in enumerate(fields["drives"])
        )
        return Marker(station, owner, drives, str(fields["safe_by"]))
    except (ValueError, TypeError, KeyError):
        return Marker(station, None)


def _value(content: bytes, index: int) -> float:
    start = HEADER + index * VALUE.size
    packed = content[start : start + VALUE.size]
    return float(VALUE.unpack(packed)[0]) if len(packed) == VALUE.size else math.nan


def _read(path: Path) -> Marker | None:
    station = path.name.removesuffix(SUFFIX)
    try:
        content = read_plain(path)
    except FileNotFoundError:
        return None
    # Unreadable is not safe: another user owns it, or a link is in its place.
    except OSError:
        return Marker(station, None)
    if not content:
        return None
    marker = decode(station, content)
    return replace(marker, is_in_use=_is_held_by_owner(marker, path.with_suffix(".lock")))


def _is_held_by_owner(marker: Marker, lock: Path) -> bool:
    """Return whether the process that energised the rig holds it, and not a later one."""
    if not is_held(lock):
        return False
    holder = holder_of(lock)
    return holder is None or marker.owner is None or holder.process == marker.owner.process


@contextmanager
def _opened(path: Path) -> Iterator[int]:
    descriptor = open_plain(path, os.O_RDWR)
    try:
        yield descriptor
    finally:
        os.close(descriptor)
