"""Finds a rig that was left energised at each start, reports it, makes it safe, and records it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from rigrunner.api.cleanup import error_text
from rigrunner.api.devices import Settable
from rigrunner.api.errors import AbortedError, DeviceError
from rigrunner.api.member import Member
from rigrunner.engine import Interference
from rigrunner.rig import agrees, unsafe_text

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from rigrunner.rig import Rig
    from rigrunner.rig_state import Marker, RigMarks

FOUND_ENERGISED = "found energised"
"""The intervention that records how the rig was found."""


class LeftAsItStandsError(AbortedError):
    """A person did not allow making the rig safe: it is left as it was found."""


class Person(Protocol):
    """A person who starts something on a rig, to whom its state is reported."""

    @property
    def by(self) -> str:
        """Name for the record."""
        ...

    def warn(self, text: str) -> None:
        """Report the state of the rig, before any question."""
        ...

    def agrees(self, question: str) -> bool:
        """Return whether the rig may be made safe now; True if no one can be asked."""
        ...


class Nobody:
    """Unattended: the rig is made safe at once."""

    by = "nobody was asked"

    def warn(self, text: str) -> None:
        """Report nothing: the state is recorded."""

    def agrees(self, question: str) -> bool:  # noqa: ARG002  (of the Protocol)
        """Allow making the rig safe."""
        return True


NOBODY = Nobody()


@dataclass(frozen=True)
class Standing:
    """The read-back of a drive, in SI units; NaN if it could not be read."""

    member: str
    unit: str
    read_back: float
    safe_value: float
    is_safe: bool
    problem: str = ""
    """Why it could not be read."""

    @property
    def text(self) -> str:
        """Return 'psu.voltage reads back 40 V, safe is 0 V'."""
        safe = f"safe is {self.safe_value:g} {self.unit}".rstrip()
        if math.isnan(self.read_back):
            return f"{self.member} cannot be read back, {safe} ({self.problem})"
        return f"{self.member} reads back {self.read_back:g} {self.unit}, {safe}"


def check_left(
    rig: Rig, marks: RigMarks | None, person: Person, station_file: str, *, reads: bool = True
) -> tuple[Interference, ...]:
    """Compare the read-backs of a connected rig with its marker; make it safe.

    Returns what to record; empty for a rig that is safe. Without `reads` only the marker counts.
    Raises LeftAsItStandsError if a person does not allow making it safe, and DeviceError if it is
    not safe.
    """
    if marks is None:
        return ()
    roles = marks.roles if reads else ()
    unsafe = [drive for drive in standing_of(rig, roles) if not drive.is_safe]
    marker = marks.left
    # Nothing to make safe: at most, record who made it safe before.
    if not unsafe and not marks.unconfirmed:
        return () if marker is None else (_interference(marker, (), person, ""),)
    if marker is None:
        person.warn(f"the rig is not safe, and no run has said so: {_texts(unsafe)}")
    elif unsafe:
        person.warn(f"its drives now: {_texts(unsafe)}")
    if unsafe and not person.agrees("Make the rig safe now? Keep away from what may move."):
        raise LeftAsItStandsError(
            f"the rig was left as it is: {_texts(unsafe)}",
            hint=f"nothing was started; 'rigrunner devices {station_file}' makes it safe",
        )
    reports = rig.make_safe()
    # Roles of the marker that were not read back now: their state is not known.
    missing = ", ".join(sorted(marks.unconfirmed))
    problem = unsafe_text(reports) or (missing and f"not read back as safe: {missing}")
    if problem:
        raise DeviceError(f"the rig is not safe: {problem}", hint=what_to_do(station_file))
    person.warn("the rig was made safe now, and each drive read back at its safe value")
    return (_interference(marker, unsafe, person, "made safe, and read back"),)


def standing_of(rig: Rig, roles: Collection[str]) -> Iterator[Standing]:
    """Yield the read-back of each drive of these roles."""
    for role, device in rig.devices.items():
        if role not in roles or not isinstance(device, Settable):
            continue
        for info in device.drives:
            problem = ""
            try:
                read_back = rig.read_back(role, info.name)
            except Exception as error:  # noqa: BLE001  (the next drive follows)
                read_back, problem = math.nan, error_text(error)
            # NaN agrees with nothing: a drive that cannot be read back is not safe.
            is_safe = agrees(info, read_back, info.safe_value)
            fields = (Member(role, info.name), info.unit, read_back, info.safe_value)
            yield Standing(*fields, is_safe=is_safe, problem=problem)


def _interference(
    marker: Marker | None, unsafe: Collection[Standing], person: Person, done: str
) -> Interference:
    report = marker.text if marker is not None else "no run had said that the rig is not safe"
    subject = "; ".join(text for text in (report, _texts(unsafe), done) if text)
    return Interference(FOUND_ENERGISED, person.by, subject=subject)


def _texts(drives: Collection[Standing]) -> str:
    return "; ".join(drive.text for drive in drives)


def settle_by(marks: RigMarks, by: str, reason: str) -> None:
    """Record that a person says that a rig is safe whose devices cannot all be read back."""
    marks.settle(f"{by.strip()} says that it is safe: {reason.strip()}")


def what_to_do(station_file: str) -> str:
    """Return the advice for a rig that cannot be confirmed safe."""
    return (
        "check the rig, and switch it off manually if necessary; then"
        f" 'rigrunner devices {station_file} --safe-by NAME --reason TEXT' records that it is safe"
    )
