"""Requirements of an analysis as data: `check`, `plan`, the panel and `run` refuse in advance.

Each number by which the analysis refuses a run is defined only here, or in the plugin that it
belongs to.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner.api.member import NAME

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.quantity import Quantity

LEAST_CYCLES = 5
"""Minimum number of whole cycles in a recording without gross errors: with fewer, neither a gross
error nor the scatter of a mean can be determined."""
SPARE_CYCLES = 1
"""Cycles to record in addition to the required ones: the drive may be slower than its set-point."""
LATEST = "latest"
"""Selects the latest matching partner run."""
STATION = "station"
_HOUR_S = 3600.0
_AFTER = "_after"
_FILES = ("procedure", STATION)
"""What the files of a run are called beside its partners."""


@dataclass(frozen=True, kw_only=True)
class NeededChannel:
    """A channel that an analysis requires."""

    name: str
    """role.name; of a counter or label its name."""
    key: tuple[str | int, ...]
    """Its place in the settings, such as ('of',)."""
    enters: tuple[str, ...] = ()
    """The results that depend on its values."""
    or_coordinate: bool = False
    """Whether a set-point, counter or label of that name replaces the channel if it is not read."""
    quantity: str = ""
    """The required kind of quantity, such as 'voltage'; '' for any."""
    spans: tuple[float, float] | None = None
    """The lowest and the highest value that it must reach, in the SI unit. Checked for set-points
    only, since readings are not known in advance."""
    values: tuple[Quantity | str, ...] = ()
    """Values at which a measurement is required; checked for set-points, counters and labels
    only."""
    shared: str = ""
    """A set-point, counter or label that must have at least one common value at all `values`."""
    within: float = 0.0
    """Allowed difference of equal values of `shared`, as a share of their range."""
    x_of: str = ""
    """For the x of a fit: the field of the settings that names the fit, whose number of different
    set-points is required."""


@dataclass(frozen=True, kw_only=True)
class NeededResult:
    """A required result of another analysis, which is calculated first."""

    name: str
    key: tuple[str | int, ...]
    """Its place in the settings, such as ('inputs', 'R')."""
    per: tuple[str, ...] | None = None
    """The only coordinates that may distinguish its values; None: any."""
    independent: bool = False
    """Whether it is independent of the others except for shared lines of the budgets: two such
    results of one analysis are refused, since they have the same scatter."""
    for_each: tuple[str, ...] = ()
    """Coordinates for each value of which it must have a value of its own."""
    for_each_of: str = ""
    """Another required result that must have the same coordinates."""


def partner_words(name: str) -> str:
    """Return a partner run in words: 'dark' is the dark run, 'dark_after' the dark run after it."""
    before = name.removesuffix(_AFTER)
    return f"{before.replace('_', '-')} run{' after it' if before != name else ''}"


@dataclass(frozen=True, kw_only=True)
class NeededRun:
    """A partner run that an analysis requires.

    It must be completed, and be no replay of a tape, unless this run is one too. Raises ValueError
    for a name that cannot be one, and for a certain `run` to be made `after` this one.
    """

    name: str
    """Name of the partner run in `run.partners[name]` and `--partner`: letters, digits and '_'.
    Analyses that use the same name must require the same run."""
    key: tuple[str | int, ...]
    """Its place in the settings, such as ('tare',)."""
    procedure: str = ""
    """The id of its procedure; '' for any."""
    run: str = LATEST
    """'latest', or a run by its folder or name."""
    max_age_s: float = 8 * _HOUR_S
    """Longest time between its start and that of this run, before or after it."""
    same: tuple[str, ...] = (STATION,)
    """What both runs must share: 'station', and keys of the rig."""
    after: bool = False
    """Whether it is made after this run, which stays open until `resume` adds it."""
    channels: tuple[NeededChannel, ...] = ()
    """Channels that must be measured in it, together in one step; their keys are not used."""
    at: tuple[str, ...] = ()
    """Set-points, counters or labels: the channels must have been measured in it at each of their
    values in this run."""
    within: float = 1e-6
    """Allowed relative difference of such a value between both runs."""
    optional: bool = False
    """Whether the analysis is also made without it, and reports what is missing."""

    def __post_init__(self) -> None:
        """Refuse a name that cannot be one, and a certain run that does not exist yet."""
        if not re.fullmatch(NAME, self.name) or self.name in _FILES:
            raise ValueError(f"'{self.name}' cannot be the name of a partner run")
        if self.after and self.run != LATEST:
            raise ValueError(f"'{self.name}' is made after this run: expected run='{LATEST}'")

    @property
    def words(self) -> str:
        """The partner run in words, such as 'dark run'."""
        return partner_words(self.name)


@dataclass(frozen=True, kw_only=True)
class Requirements:
    """Requirements of an analysis, an outlier rule or a fit, from its settings alone.

    The defaults require nothing.
    """

    channels: tuple[NeededChannel, ...] = ()
    """Channels that must be measured together in one step."""
    results: tuple[NeededResult, ...] = ()
    """Results of other analyses of the procedure, which are calculated first."""
    partners: tuple[NeededRun, ...] = ()
    """Partner runs."""
    cycles: int = 0
    """Minimum number of whole cycles in each recording."""
    rate_hz: float = 0.0
    """Minimum samples per second in each recording of its channels."""
    points: int = 0
    """Minimum number of different x of a fit."""
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Parameters of a fit, each with its SI unit, or '' if that follows from the points; empty if
    they do not follow from the settings."""
