"""Locks a rig for one run: by the id of the station and the addresses of its instruments."""

from __future__ import annotations

import hashlib
import os
import socket
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceError
from rigrunner.clock import utc_text
from rigrunner.rig_state import (
    Busy,
    Holder,
    Owner,
    RigMarks,
    canonical,
    hold,
    read_markers,
    shared_folder,
)
from rigrunner.run.guardian.guarded import real_roles

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.registry import Registry
    from rigrunner.run.prepare import Planned
    from rigrunner.station import LoadedStation


@dataclass(frozen=True)
class Place:
    """The address of the instrument in a role."""

    role: str
    written: str
    """As written in the station: 'serial:/dev/ttyUSB0'."""
    addresses: frozenset[str]
    """The same in canonical form; one instrument may have several."""


@contextmanager
def rig_lock(planned: Planned) -> Iterator[RigMarks | None]:
    """Hold the rig of a planned run; a replay needs no rig."""
    if planned.tape is not None and planned.tape.replays:
        yield None
        return
    with station_lock(planned.station, planned.registry, planned.procedure.model.id) as marks:
        yield marks


@contextmanager
def station_lock(
    station: LoadedStation, registry: Registry, what: str
) -> Iterator[RigMarks | None]:
    """Hold the rig of a station for this process; raise DeviceError if another process has it.

    The rig is locked, for all users of this machine, by the id of the station and by each address
    of its instruments. `what` is the purpose, shown to others. Yields the marks of the rig.
    A station of simulators alone is not locked and yields None: each process simulates its own rig.
    Raises DeviceError also if another station left one of the instruments energised.
    """
    real = real_roles(station, registry)
    if not real:
        yield None
        return
    now, station_id, process = utc_text(datetime.now(UTC)), station.model.id, os.getpid()
    # Those that no other run may use at the same time.
    places = [
        Place(role, written, canonical(written))
        for role in real
        if not (binding := station.model.devices[role]).shared
        for written in registry.physical_addresses(binding.plugin, binding.settings)
    ]
    folder = shared_folder()
    holder = Holder(station_id, what, process, now)
    with ExitStack() as stack:
        lock = folder / f"{station_id}.lock"
        locks = {lock: _take(stack, lock, holder, f"the rig of station {station_id}")}
        taken: set[str] = set()
        for place in places:
            instrument = f"the instrument of '{place.role}' at {place.written}"
            # Several roles may have one address; a second lock on it would wait for the first.
            for address in sorted(place.addresses - taken):
                # The dot keeps it apart from the ids of stations.
                lock = folder / f".{hashlib.sha256(address.encode()).hexdigest()[:24]}.lock"
                locks[lock] = _take(stack, lock, holder, instrument)
            taken |= place.addresses
        # With the locks held: no other run can energise these instruments any more.
        _refuse_left_by_others(station_id, places)
        by_role: dict[str, set[str]] = {}
        for place in places:
            by_role.setdefault(place.role, set()).update(place.addresses)
        owner = Owner(
            station=station_id,
            station_file=os.path.abspath(station.document.name),  # noqa: PTH100  (a name, not our path)
            procedure=what,
            process=process,
            host=socket.gethostname(),
            since=now,
            plugins={role: station.model.devices[role].plugin for role in real},
            addresses={role: tuple(sorted(addresses)) for role, addresses in by_role.items()},
        )
        yield RigMarks(owner, real, locks)


def _take(stack: ExitStack, lock_file: Path, holder: Holder, what: str) -> int:
    """Hold a lock; return its file descriptor, -1 for none."""
    try:
        (descriptor,) = stack.enter_context(hold([lock_file], holder))
    except Busy as busy:
        by, present = "", busy.holder
        if present is not None:
            station = "" if present.station == holder.station else f" on station {present.station}"
            by = f": {present.procedure}{station}, process {present.process}, since {present.since}"
        raise DeviceError(
            f"{what} is in use{by}",
            hint="wait for that run, or stop it; two rigs need two station ids, and instruments of"
            " their own",
        ) from busy
    except OSError as error:
        text = f"the rig cannot be locked: {error}"
        raise DeviceError(text, hint=f"see {lock_file}") from error
    return descriptor


def _refuse_left_by_others(station_id: str, places: list[Place]) -> None:
    """Raise DeviceError if a run on another station left one of these instruments energised."""
    for marker in read_markers():
        if marker.station == station_id or marker.owner is None or marker.safe_by:
            continue
        energised = set[str]().union(*marker.owner.addresses.values())
        for place in places:
            if place.addresses & energised:
                raise DeviceError(
                    f"the instrument of '{place.role}' at {place.written} is not known to be safe:"
                    f" {marker.text}",
                    hint=f"'rigrunner devices {marker.owner.station_file}' makes it safe first",
                )
