"""Where the drives stand while a procedure is walked through, and what follows from it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner.api.coordinates import has_display_unit
from rigrunner.api.member import Member
from rigrunner.api.units import from_si

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.devices import DriveInfo
    from rigrunner.api.quantity import Quantity
    from rigrunner.plan.bench import Bench
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path
    from rigrunner.yamlfile.problems import Problems


@dataclass(eq=False)
class _Standing:
    """Where the drives stand, whichever procedure brought them there."""

    values: dict[str, float] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    written: dict[str, str] = field(default_factory=dict)
    uncertain: bool = False


class DriveStates:
    """The drives that have been set, and to what; what does not fit is added to the problems."""

    def __init__(
        self,
        bench: Bench,
        document: Document,
        problems: Problems,
        standing: _Standing | None = None,
    ) -> None:
        self._bench = bench
        self._document = document
        self._problems = problems
        self._standing = standing or _Standing()

    def of(self, bench: Bench, document: Document) -> DriveStates:
        """Return the same drives as a called procedure moves them."""
        return DriveStates(bench, document, self._problems, self._standing)

    def values(self) -> dict[str, float]:
        """Return what each drive was set to, in SI units."""
        return dict(self._standing.values)

    def units(self) -> dict[str, str]:
        """Return the unit of each drive that was set."""
        return dict(self._standing.units)

    def written(self) -> dict[str, str]:
        """Return the unit in which each set-point is written, where that has to be kept."""
        units, written = self._standing.units, self._standing.written
        return {
            name: symbol
            for name, symbol in written.items()
            if has_display_unit(symbol, units[name])
        }

    def changed(self, before: Mapping[str, float]) -> Iterator[tuple[Member, float, str]]:
        """Yield each drive that stands elsewhere than before, with where and in which unit."""
        for name, value in self._standing.values.items():
            drive = Member.parse(name)
            if value != before.get(name, self._bench.safe_value(drive)):
                yield drive, value, self._standing.units[name]

    def standing(self, member: Member, drive: DriveInfo) -> float:
        """Return where a drive stands: where it was set, or else at its safe value."""
        return self._standing.values.get(member, drive.safe_value)

    def resolve(
        self, member: Member, quantity: Quantity, named_at: Path, valued_at: Path, *, key: bool
    ) -> DriveInfo | None:
        """Return the drive if it can be set to that; else add the problem and return None."""
        drive = self._bench.drive(member, named_at, key=key)
        if drive is None or not self._bench.fits(quantity, drive.unit, member, valued_at):
            # What follows from this drive would be complaints about nothing.
            self._standing.uncertain = True
            return None
        if not drive.minimum <= quantity.si <= drive.maximum:
            symbol = quantity.unit.symbol
            low, high = (f"{from_si(end, symbol):.6g}" for end in (drive.minimum, drive.maximum))
            allowed = drive.range_text if "e" in low + high else f"{low} to {high} {symbol}"
            message = f"{quantity} is out of range ({allowed})"
            hint = f"these are the limits of {member}"
            self._problems.add(self._document, valued_at, message, hint)
        elif not self._standing.uncertain:
            self._check_together(member, quantity, valued_at)
        return drive

    def _check_together(self, member: Member, quantity: Quantity, valued_at: Path) -> None:
        """Add a problem for a set-point that is not allowed with where other drives stand."""
        for combination in self._bench.rules.combinations:
            if member not in combination.drives:
                continue
            others: dict[Member, float] = {}
            for drive in combination.drives:
                if drive != member:
                    value = self._standing.values.get(drive)
                    others[drive] = self._bench.safe_value(drive) if value is None else value
            if not combination.allows({**others, member: quantity.si}):
                message = f"got '{quantity}', not allowed with {combination.others(member, others)}"
                hint = f"expected {combination.words()}"
                self._problems.add(self._document, valued_at, message, hint)

    def move(self, member: Member, drive: DriveInfo, value: float, written: str = "") -> float:
        """Set the drive and return how many seconds it takes; it starts from its safe value."""
        distance = abs(value - self.standing(member, drive))
        name = str(member)  # a mapping with plain texts as keys is smaller, and each step has one
        self._standing.values[name], self._standing.units[name] = value, drive.unit
        self._standing.written[name] = written or drive.unit
        return distance / drive.rate_per_s if drive.rate_per_s else 0.0

    def known_cycle_frequency_hz(self, role: str) -> float | None:
        """Return the frequency at which the role's device moves, if one is set."""
        drive = self._cycle_drive(role)
        return self._standing.values.get(drive) if drive else None

    def cycle_frequency_hz(self, role: str | None, path: Path) -> float | None:
        """Return the frequency that cycles are counted by, or None after adding the problem."""
        drive = self._cycle_drive(role)
        if self._standing.uncertain:
            return None
        if drive is None:
            message = "no device here has a drive that sets a cycle frequency"
            if drives := self._bench.cycle_drives():
                message = f"several drives set a cycle frequency: {', '.join(drives)}"
            self._problems.add(self._document, path, message, "give a time")
            return None
        value = self._standing.values.get(drive, 0.0)
        if value <= 0:
            message = f"cycles need a frequency, but {drive} is not set above 0 Hz here"
            self._problems.add(self._document, path, message, f"set {drive} before, or give a time")
            return None
        return value

    def is_readable(self, role: str, at: Mapping[str, float], path: Path) -> bool:
        """Say whether a role's device can be read where the drives stand; add the problem.

        `at`: where some of them stand then, in place of where they were set.
        """
        if self._standing.uncertain:
            return True
        return self._bench.is_readable_at(role, {**self._standing.values, **at}, path)

    def require_rest(self, role: str, path: Path) -> None:
        """Add a problem if the role's device is moving."""
        frequency_hz = self.known_cycle_frequency_hz(role)
        if frequency_hz:
            drive = self._cycle_drive(role)
            message = f"zero is read at rest, but {drive} is at {frequency_hz:g} Hz here"
            self._problems.add(self._document, path, message, f"set {drive} to 0 Hz before")

    def _cycle_drive(self, role: str | None) -> Member | None:
        """Return the cyclic drive of that role, or else the only one there is."""
        drives = self._bench.cycle_drives()
        candidates = [drive for drive in drives if drive.role == role] or drives
        return candidates[0] if len(candidates) == 1 else None
