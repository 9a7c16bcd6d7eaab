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
from rigrunner.rig_state.folder import open_plain, shared_folder, sync_names
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
        left = read_marker(owner.station)
        # This process has the lock now, so the process that left the marker has not.
        self.left = None if left is None else replace(left, is_in_use=False)
        """The marker that an earlier process left; None if it left the rig safe."""
        self.unconfirmed = self._left_roles()
        """Roles of that marker that were not read back as safe since."""
        self._drives: list[DriveMark] = []
        self._places: dict[str, int] = {}
        """Index of each 'role.drive'."""
        self._values: list[float] = []
        """Last set-point of each."""
        self._opened = -1
        self._writing = threading.Lock()
        """Held while the file is written: what keeps it from being removed is another thread."""

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
        with self._writing:
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
        places, values, pack = self._places, self._values, VALUE.pack

        def note(value: float) -> None:
            place = places.get(member)
            if place is None:
                if value != safe_value:
                    self._add(DriveMark(member, info.unit, safe_value, value))
            elif values[place] != value:
                try:
                    # Eight bytes, not synced: the page cache survives the process (decision 22).
                    with self._writing:
                        os.lseek(self._opened, HEADER + place * VALUE.size, os.SEEK_SET)
                        os.write(self._opened, pack(value))
                except OSError as error:
                    # The way to the safe value has to stay open.
                    if value != safe_value:
                        raise _unwritten(error) from error
                values[place] = value

        return note

    def energise(self, role: str, drives: Sequence[DriveInfo]) -> None:
        """Mark drives whose set-points are not known in advance; raise DeviceError."""
        for info in drives:
            if (member := Member(role, info.name)) not in self._places:
                self._add(DriveMark(member, info.unit, info.safe_value, math.nan))

    def confirm(self, roles: Collection[str]) -> None:
        """Remove drives of devices that were read back as safe, and with the last one the marker.

        If this cannot be written, the next start takes the rig for energised.
        """
        if self.unconfirmed:
            self.unconfirmed -= frozenset(roles)
            if not self.unconfirmed:
                self.settle(f"'{self.owner.procedure}' made it safe")
        left = [each for each in self._now() if each.member.role not in roles]
        # Nothing of this process: a marker on the disk may be of another one.
        if len(left) == len(self._drives):
            return
        with self._writing, suppress(DeviceError, OSError):
            self._keep(left)
            if left:
                self._write()
            else:
                self._close()
                clear(self.owner.station)

    def renew(self) -> None:
        """Write the marker again if its file was removed; raise DeviceError."""
        with self._writing:
            if self._drives and (self._opened < 0 or is_removed(self._opened)):
                self._close()
                try:
                    self._write()
                except DeviceError:
                    self._close()  # it is tried again
                    raise

    def touch(self) -> None:
        """Mark its file as used now. POSIX only."""
        with self._writing, suppress(OSError):
            os.utime(self._opened)

    def settle(self, how: str) -> None:
        """Record in the marker of an earlier process how its rig was made safe."""
        self.unconfirmed = frozenset()
        with suppress(DeviceError, OSError):
            record_made_safe(self.owner.station, f"{how} (process {self.owner.process})")
        left = read_marker(self.owner.station)
        self.left = None if left is None else replace(left, is_in_use=False)

    def put_on_record(self) -> None:
        """Remove the marker of an earlier process, once it has been recorded elsewhere."""
        if self.left is not None and not self.unconfirmed and not self._drives:
            with suppress(DeviceError, OSError):
                clear(self.owner.station)
            self.left = None

    def _left_roles(self) -> frozenset[str]:
        if self.left is None or self.left.safe_by:
            return frozenset()
        named = frozenset(each.member.role for each in self.left.drives)
        return named or self.roles  # of a marker that cannot be read

    def _add(self, drive: DriveMark) -> None:
        with self._writing:
            before = self._now()
            self._keep([*before, drive])
            try:
                self._write()
            except DeviceError:
                self._keep(before)
                self._restore()
                raise

    def _restore(self) -> None:
        """Remove what of a marker is on a full disk: the drive that it is for was not set.

        If that fails too, or if an earlier process may have left the rig energised, the next start
        takes it for energised.
        """
        with suppress(DeviceError, OSError):
            if self._drives:
                self._write()
            elif not self.unconfirmed:
                self._close()
                clear(self.owner.station)

    def _keep(self, drives: list[DriveMark]) -> None:
        self._drives = drives
        # In place: the functions of `before_set` hold both collections.
        self._values[:] = [each.set_point for each in drives]
        self._places.clear()
        self._places.update((each.member, place) for place, each in enumerate(drives))

    def _now(self) -> list[DriveMark]:
        return [
            replace(each, set_point=value)
            for each, value in zip(self._drives, self._values, strict=True)
        ]

    def _write(self) -> None:
        """Write the whole marker; return once it is on the disk."""
        try:
            if self._opened < 0:
                path = shared_folder() / f"{self.owner.station}{SUFFIX}"
                self._opened = open_plain(path, os.O_RDWR | os.O_CREAT)
                # A new file is found after a power failure only if its name is on the disk too.
                sync_names(path.parent)
            overwrite(self._opened, encode(self.owner, tuple(self._now())))
        except OSError as error:
            raise _unwritten(error) from error

    def _close(self) -> None:
        if self._opened >= 0:
            os.close(self._opened)
            self._opened = -1


def _unwritten(error: OSError) -> DeviceError:
    return DeviceError(
        f"the marker of the energised rig cannot be written: {error.strerror or error}",
        hint="no drive is set without it, as the next start could not tell that the rig is"
        " energised; see RIGRUNNER_LOCKS in the documentation",
    )
