"""What a kind of step plans with: its place, the devices, and where the drives stand by then."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Protocol

from rigrunner.api.steps import NONE
from rigrunner.api.units import rate_of, unit, units_of, with_article
from rigrunner.plan.actions import PlannedRecording
from rigrunner.plan.terms import planned_limits, recorded_limits, terms_of

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterable, Mapping, Sequence

    from rigrunner.api.devices import ChannelInfo
    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.member import Member
    from rigrunner.api.planned import RecordingAction
    from rigrunner.api.quantity import Quantity
    from rigrunner.api.readings import ReadingLimit
    from rigrunner.api.steps import Action, StepSettings
    from rigrunner.plan.draft import Place, Scene
    from rigrunner.procedure.options import RecordedBand, ValueBand
    from rigrunner.procedure.steps import Step

Key = tuple[str | int, ...]


class Walker(Protocol):
    """Goes through steps that stand within another one."""

    def steps(self, steps: Sequence[Step], place: Place) -> None:
        """Plan steps of the same procedure."""
        ...

    def call(self, place: Place) -> None:
        """Plan the steps of the procedure that the step at a place calls."""
        ...


@dataclass(frozen=True, eq=False)
class Planning:
    """Plans one step: see `rigrunner.api.steps.Planning`."""

    settings: StepSettings
    place: Place
    """Under the key of the step."""
    scene: Scene
    walker: Walker

    def emit(
        self,
        action: Action,
        text: str,
        seconds: float = 0.0,
        limits: Iterable[ValueLimit] | None = None,
        *,
        at: Place | None = None,
        expected: Iterable[ReadingLimit] = (),
    ) -> None:
        """Write down one action, with the terms that the step has; `at`: elsewhere in it."""
        terms = terms_of(self.settings, self.place, seconds, self.scene, limits, expected=expected)
        self.scene.emit(at or self.place, action, text, seconds, terms)

    def complain(self, key: Key, message: str, hint: str = "") -> None:
        """Add a problem with what stands under a key of the step."""
        self.scene.complain(self.path(*key), message, hint)

    def path(self, *key: str | int) -> Key:
        """Return where a key of the step stands in the file."""
        return (*self.place.path, *key)

    def channel(self, member: Member, key: Key) -> ChannelInfo | None:
        """Return a channel of a device, or None after adding the problem."""
        return self.scene.bench.channel(member, self.path(*key))

    def units(self, channels: Sequence[Member], key: Key = ("channels",)) -> dict[Member, str]:
        """Return each channel's unit; none at all where there is a problem with one."""
        find_units = partial(self._units, channels, key)
        # A copy: a kind may add to it.
        return dict(self.scene.cached(self.place, ("units", key, *channels), find_units))

    def _units(self, channels: Sequence[Member], key: Key) -> dict[Member, str]:
        infos = {each: self.channel(each, (*key, index)) for index, each in enumerate(channels)}
        if len(infos) < len(channels):
            self.complain(key, "a channel is listed twice", "name it once")
            return {}
        units = {member: info.unit for member, info in infos.items() if info}
        return units if len(units) == len(infos) else {}

    def must_be_read(
        self, channels: Iterable[Member], at: Mapping[str, float] = NONE, key: Key = ()
    ) -> bool:
        """Add a problem for each device of which single values cannot be read.

        Return whether they can be where its drives stand, or `at` other set-points.
        """
        roles = dict.fromkeys(member.role for member in channels)
        for role in roles:
            self.scene.bench.must_be_readable(role, self.place.path)
        return all(self.scene.drives.is_readable(role, at, self.path(*key)) for role in roles)

    def fits(self, quantity: Quantity, symbol: str, member: Member, key: Key) -> bool:
        """Say whether a quantity has the dimension of a unit; add the problem if not."""
        return self.scene.bench.fits(quantity, symbol, member, self.path(*key))

    def move(self, drive: Member, to: Quantity, named: Key, key: Key) -> tuple[str, float] | None:
        """Let the plan know that a drive is set: return its unit, and how long that takes in s."""
        by_key = named == key
        info = self.scene.drives.resolve(drive, to, self.path(*named), self.path(*key), key=by_key)
        if info is None:
            return None
        return info.unit, self.scene.drives.move(drive, info, to.si, to.unit.symbol)

    def require_rest(self, role: str) -> None:
        """Add a problem if the role's device moves in cycles by then."""
        self.scene.drives.require_rest(role, self.place.path)

    def setpoints(self) -> dict[str, float]:
        """Return what each drive was set to by then, in SI units."""
        return self.scene.drives.values()

    def drive_units(self) -> dict[str, str]:
        """Return the unit of each drive that was set by then."""
        return self.scene.drives.units()

    def rate(self, rate: Quantity, symbol: str, member: Member, key: Key) -> float | None:
        """Return a rate of what has this unit, in SI; None after adding what is wrong with it."""
        dimension = unit(symbol).dimension
        dimension_of_rate = rate_of(dimension)
        if dimension_of_rate is None:
            self.complain(
                key, f"there is no unit for the rate of {with_article(dimension)}", "give a time"
            )
        elif rate.dimension != dimension_of_rate:
            message = (
                f"got '{rate}', {with_article(rate.dimension)}; {member} takes"
                f" {with_article(dimension_of_rate)}"
            )
            self.complain(key, message, f"write it in {' or '.join(units_of(dimension_of_rate))}")
        elif rate.si <= 0:
            self.complain(key, f"got '{rate}', expected more than 0")
        else:
            return rate.si
        return None

    def recorded_limits(
        self,
        bands: Mapping[Member, RecordedBand],
        channels: Sequence[Member],
        beside: Sequence[Member],
    ) -> list[ValueLimit]:
        """Return the limits of samples of channels, and of values that are read `beside`."""
        return list(recorded_limits(bands, channels, beside, self.place, self.scene))

    def times_before(self, *what: Hashable) -> int:
        """Return how often this step of the file was written down before; of some more, for each.

        Call it once each time.
        """
        counter = (id(self.scene.document), self.place.path, *what)
        self.scene.draft.repeated[counter] += 1
        return self.scene.draft.repeated[counter] - 1

    def record(self, recording: RecordingAction, beside: Sequence[Member]) -> None:
        """Take note of a recording, and of what is read beside it."""
        recorded = PlannedRecording(
            recording,
            self.scene.document,
            self.place.path,
            beside,
            self.place.coordinates,
            self.place.coordinate_units,
        )
        self.scene.draft.recordings.append(recorded)

    def limits(
        self, bands: Mapping[Member, ValueBand], found: Sequence[Member]
    ) -> list[ValueLimit]:
        """Return the limits of the channels `found`; what does not fit them is a problem."""

        def make() -> tuple[ValueLimit, ...]:
            return tuple(planned_limits(bands, self.place, found, self.scene))

        return list(self.scene.cached(self.place, ("limits", *bands, *found), make))
