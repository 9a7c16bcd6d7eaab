"""`scan`: a drive is set to a list of set-points, and channels are read at each into one table."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from rigrunner.api.errors import DataError, DeviceError
from rigrunner.api.events import Scanned
from rigrunner.api.hooks import StepRecord
from rigrunner.api.member import Member
from rigrunner.api.names import Name
from rigrunner.api.settings import AnyQuantity, ListOf, PositiveDuration
from rigrunner.api.steps import NONE, Action, Rows, StepResult, StepSettings
from rigrunner.procedure.options import Channels, Limits, Repeatable, Retries, Timeout
from rigrunner.steps.set_drives import SetDrive

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.limits import ValueLimit
    from rigrunner.engine.session import Session
    from rigrunner.plan.planning import Planning


class ScanStep(StepSettings):
    """Sets a drive to each of a list of set-points, and reads channels: one step, one table.

    A sweep executes any steps at each set-point; a scan only reads, and is as fast as its devices.
    """

    set: Member
    """Role and drive, such as press.load."""
    over: Annotated[ListOf[AnyQuantity], Field(min_length=1)]
    """The set-points in order."""
    channels: Channels
    """Roles and channels, such as [press.torque]; read once at each set-point."""
    name: Name = "measured"
    """Name of the table."""
    settle: PositiveDuration | None = None
    """Waiting time at each set-point before reading."""
    limits: Limits = Field(default_factory=dict)
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True
    on_fail: Annotated[
        Literal["stop", "continue"],
        Field(
            description="Action after a value out of its limits: end the run, or continue with"
            " the next point. A device failure always ends the run: the drive would not be where"
            " the next steps expect it."
        ),
    ] = "stop"

    def actions(self) -> int:
        """Return the number of set-points."""
        return len(self.over)


@dataclass(frozen=True)
class Scan(Action):
    """Sets one drive to each set-point and reads channels once: a row of a table."""

    kind = "scan"
    reads = drives_stay = True
    name: str
    """Name of the table."""
    role: str
    drive: str
    values: tuple[float, ...]
    """The set-points in order, in the SI unit of the drive."""
    channels: tuple[Member, ...]
    settle_s: float
    """Waiting time at each set-point; 0 for none."""
    setpoints: Mapping[str, float]
    """As for a recording, without this drive."""
    units: Mapping[str, str]
    """As for a recording."""
    limits: tuple[ValueLimit, ...] = ()
    """Limits of the values of each row."""
    stops_at_limit: bool = True
    """Whether the first value out of limits ends scan and run."""

    @cached_property
    def moves(self) -> Member:
        """The drive."""
        return Member(self.role, self.drive)

    @property
    def moves_to(self) -> tuple[float, ...]:
        """The set-points."""
        return self.values

    @property
    def restoring(self) -> SetDrive:
        """The action that sets the drive to its last set-point, without reading again."""
        return SetDrive(self.role, self.drive, self.values[-1], self.units[self.moves])

    @property
    def rows(self) -> Rows:
        """A row for each set-point."""
        where = tuple({**self.setpoints, self.moves: value} for value in self.values)
        return Rows(self.name, self.channels, self.units, where)

    @property
    def setpoints_and_units(self) -> tuple[Mapping[str, float], Mapping[str, str]]:
        """Set-points of the other drives, and the units."""
        return self.setpoints, self.units

    @property
    def checked_limits(self) -> tuple[ValueLimit, ...]:
        """The limits of each row."""
        return self.limits

    def where(self, point: int) -> str:
        """Return 'press.load 20 N (point 2 of 10)'."""
        number = f"point {point + 1} of {len(self.values)}"
        return f"{self.moves} {self.values[point]:g} {self.units[self.moves]} ({number})"

    def do(self, step: str, doing: Session) -> StepResult:
        """Do all points, recording each before the next; return the values of the last one.

        Between two points the same happens as between two steps: the run can be stopped or paused,
        and all interlocks are read. The first row out of limits ends it if the procedure says so,
        and is named in what is returned. Raises the errors of the devices, with the set-point.
        """
        emit, member = doing.emit, self.moves
        move, read = doing.leader(self.role, self.drive), doing.reader(self.channels)
        values: Mapping[str, float] = NONE
        for point, value in enumerate(self.values):
            try:
                # Before the first point the engine has just checked, as before each step.
                if point:
                    doing.check(read_all=True)
                move(value)
                if self.settle_s:
                    doing.wait(self.settle_s)
                values = read()
            except (DeviceError, DataError) as error:
                error.message = f"at {self.where(point)}: {error.message}"
                raise
            # Before it is judged: a row out of limits is kept like any other.
            emit(
                Scanned,
                step=step,
                point=point,
                measurement=self.name,
                setpoints={**self.setpoints, member: value},
                values=values,
            )
            if self.limits:
                missed = doing.judge(step, self.limits, values, partial(self.where, point))
                if missed and self.stops_at_limit:
                    return StepResult(values, self.units, NONE, missed=missed)
        return StepResult(values, self.units, NONE)


def plan(scan: ScanStep, planning: Planning) -> None:
    """Plan the set-points and the channels."""
    before, units = planning.setpoints(), planning.units(scan.channels)
    moves = [
        planning.move(scan.set, quantity, ("set",), ("over", index))
        for index, quantity in enumerate(scan.over)
    ]
    for index, quantity in enumerate(scan.over):
        if not planning.must_be_read(units, {scan.set: quantity.si}, ("over", index)):
            break  # one such set-point is reported for all
    limits = tuple(planning.limits(scan.limits, scan.channels)) if units else ()
    if not units or None in moves:
        return
    action = Scan(
        name=scan.name,
        role=scan.set.role,
        drive=scan.set.name,
        values=tuple(quantity.si for quantity in scan.over),
        channels=scan.channels,
        settle_s=scan.settle or 0.0,
        setpoints={member: value for member, value in before.items() if member != scan.set},
        units=planning.drive_units() | units,
        limits=limits,
        stops_at_limit=scan.on_fail == "stop",
    )
    least, most = (end(scan.over, key=lambda quantity: quantity.si) for end in (min, max))
    count = len(scan.over)
    span = f"between {least} and {most}, {count} points" if count > 1 else f"at {least}, 1 point"
    text = f"Scan {scan.set} {span}, reading {', '.join(scan.channels)}"
    moving_s = sum(move[1] for move in moves if move)
    planning.emit(action, text, moving_s + count * (scan.settle or 0.0))


STEP = StepRecord(
    name="scan",
    help="Sets a drive to a list of set-points and reads channels at each, into one table.",
    settings=ScanStep,
    factory=plan,
    example="scan: {set: role.drive, over: [1 N, 2 N], channels: [role.name]}",
    trial={"set": "tester.load", "over": ["0 N", "100 N"], "channels": ["tester.load"]},
)
