"""Updates the marker of a rig while a process drives it."""

from __future__ import annotations

import math
import os
import threading
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceError
from rigrunner.api.member import Member
from rigrunner.rig_state.folder import folder_path, open_plain, shared_folder, sync_names
from rigrunner.rig_state.locks import is_removed
from rigrunner.rig_state.marker import (
    HEADER,
    SUFFIX,
    VALUE,
    DriveMark,
    Owner,
    clear,
    encode,
    overwrite,
    read_marker,
    record_made_safe,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.devices import DriveInfo


class RigMarks:
    """The marker of one rig, updated by the process that holds it.

    `roles` are those of real devices: simulators end with the process.
    """

    def __init__(
        self,
        owner: Owner,
        roles: Collection[str],
        locks: Mapping[Path, int] | None = None,
    ) -> None:
        self.owner = owner
        self.locks = dict(locks or {})
        """The lock files of the rig, with descriptors that a process can inherit."""
        self.roles = frozenset(roles)
        marker = read_marker(owner.station)
        # This process has the lock now, so the process that left the marker has not.
        self.left = None if marker is None else replace(marker, is_in_use=False)
        """The marker that an earlier process left; None if it left the rig safe."""
        self.unconfirmed = self._left_roles()
        """Roles of that marker that were not read back as safe since."""
        self._drives: list[DriveMark] = []
        self._indices: dict[str, int] = {}
        """Index of each 'role.drive'."""
        self._values: list[float] = []
        """Last set-point of each."""
        self._descriptor = -1
        self._write_lock = threading.Lock()
        """Held while the file is written: `keeping` recreates it in another thread."""

    def describe(self, *, run: str = "", guardian: str = "", unguarded: str = "") -> None:
        """Add the folder of the run, or the guardian and the devices it cannot reach.

        Raises DeviceError. To be called only by the thread that drives the rig.
        """
        self.owner = replace(
            self.owner,
            run=run or self.owner.run,
            guardian=guardian or self.owner.guardian,
            unguarded=unguarded or self.owner.unguarded,
        )
        with self._write_lock:
            if self._drives:
                self._write()

    def before_set(self, role: str, info: DriveInfo) -> Callable[[float], None] | None:
        """Return the function to call with each set-point of a drive before it is sent.

        It raises DeviceError if the marker cannot be written: then the drive must not be set. A
        safe value is never refused. None for a simulated device.
        """
        if role not in self.roles:
            return None
        member, safe_value = Member(role, info.name), info.safe_value
        indices, values, pack = self._indices, self._values, VALUE.pack

        def note(value: float) -> None:
            index = indices.get(member)
            if index is None:
                if value != safe_value:
                    self._add(DriveMark(member, info.unit, safe_value, value))
            elif values[index] != value:
                with self._write_lock:
                    try:
                        # Eight bytes, not synced: the page cache survives this (decision 22).
                        os.lseek(self._descriptor, HEADER + index * VALUE.size, os.SEEK_SET)
                        os.write(self._descriptor, pack(value))
                    except OSError as error:
                        # Setting the safe value must stay possible.
                        if value != safe_value:
                            raise _write_error(error) from error
                    values[index] = value  # with the lock: `keeping` may write all of them anew

        return note

    def energise(self, role: str, drives: Sequence[DriveInfo]) -> None:
        """Mark drives whose set-points are not known in advance; raise DeviceError."""
        for info in drives:
            if (member := Member(role, info.name)) not in self._indices:
                self._add(DriveMark(member, info.unit, info.safe_value, math.nan))

    def confirm(self, roles: Collection[str]) -> None:
        """Remove drives of devices that were read back as safe, and with the last one the marker.

        If this cannot be written, the next start takes the rig for energised.
        """
        if self.unconfirmed:
            self.unconfirmed -= frozenset(roles)
            if not self.unconfirmed:
                self.settle(f"'{self.owner.procedure}' made it safe")
        remaining = [mark for mark in self._current_drives() if mark.member.role not in roles]
        # Nothing of this process: a marker on the disk may be another's.
        if len(remaining) == len(self._drives):
            return
        with self._write_lock, suppress(DeviceError, OSError):
            self._replace_drives(remaining)
            if remaining:
                self._write()
            else:
                self._close()
                clear(self.owner.station)

    def renew(self) -> None:
        """Write the marker again if its file was removed; raise DeviceError."""
        with self._write_lock:
            if self._drives and (self._descriptor < 0 or is_removed(self._descriptor)):
                self._close()
                try:
                    self._write()
                except DeviceError:
                    self._close()  # it is tried again
                    raise

    def touch(self) -> None:
        """Mark its file as used now. POSIX only."""
        with self._write_lock, suppress(OSError):
            os.utime(self._descriptor)

    def settle(self, how: str) -> None:
        """Record in the marker of an earlier process how its rig was made safe."""
        self.unconfirmed = frozenset()
        with suppress(DeviceError, OSError):
            record_made_safe(self.owner.station, f"{how} (process {self.owner.process})")
        marker = read_marker(self.owner.station)
        self.left = None if marker is None else replace(marker, is_in_use=False)

    def put_on_record(self) -> None:
        """Remove the marker of an earlier process, once it has been recorded elsewhere."""
        if self.left is not None and not self.unconfirmed and not self._drives:
            with suppress(DeviceError, OSError):
                clear(self.owner.station)
            self.left = None

    def _left_roles(self) -> frozenset[str]:
        if self.left is None or self.left.safe_by:
            return frozenset()
        roles = frozenset(mark.member.role for mark in self.left.drives)
        return roles or self.roles  # of a marker that cannot be read

    def _add(self, drive: DriveMark) -> None:
        with self._write_lock:
            previous = self._current_drives()
            self._replace_drives([*previous, drive])
            try:
                self._write()
            except DeviceError:
                self._replace_drives(previous)
                self._restore()
                raise

    def _restore(self) -> None:
        """Undo a marker that a full disk cut short: its new drive was not set.

        If that fails too, or if an earlier process may have left the rig energised, the next start
        takes it for energised.
        """
        with suppress(DeviceError, OSError):
            if self._drives:
                self._write()
            elif not self.unconfirmed:
                self._close()
                clear(self.owner.station)

    def _replace_drives(self, drives: list[DriveMark]) -> None:
        self._drives = drives
        # In place: the functions of `before_set` hold both collections.
        self._values[:] = [drive.set_point for drive in drives]
        self._indices.clear()
        self._indices.update((drive.member, index) for index, drive in enumerate(drives))

    def _current_drives(self) -> list[DriveMark]:
        return [
            replace(mark, set_point=value)
            for mark, value in zip(self._drives, self._values, strict=True)
        ]

    def _write(self) -> None:
        """Write the whole marker; return once it is on the disk."""
        try:
            if self._descriptor < 0:
                path = shared_folder() / f"{self.owner.station}{SUFFIX}"
                self._descriptor = open_plain(path, os.O_RDWR | os.O_CREAT)
                # A new file is found after a power failure only if its name is on the disk too.
                sync_names(path.parent)
            overwrite(self._descriptor, encode(self.owner, tuple(self._current_drives())))
        except OSError as error:
            raise _write_error(error) from error

    def _close(self) -> None:
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def _write_error(error: OSError) -> DeviceError:
    return DeviceError(
        f"the marker of the energised rig cannot be written: {error.strerror or error}",
        hint="no drive is set without it, as the next start could not tell that the rig is"
        f" energised; it is in {folder_path()}: see RIGRUNNER_LOCKS in the documentation",
    )
