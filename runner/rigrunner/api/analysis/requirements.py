"""What an analysis needs of a run, as data: `check`, `plan`, the panel and `run` refuse in time.

Each number by which the analysis refuses a run has its only home here, or beside the plugin whose
number it is.
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
"""Whole cycles in a recording, after gross errors: with fewer, neither a gross error nor the
scatter of a mean can be determined."""
SPARE_CYCLES = 1
"""Cycles to record beyond those that are needed: the drive may turn slower than it is set."""
LATEST = "latest"
"""Of a partner run: the latest that fits."""
STATION = "station"
_HOUR_S = 3600.0
_AFTER = "_after"
_FILES = ("procedure", STATION)
"""What the files of a run are called beside its partners."""


@dataclass(frozen=True, kw_only=True)
class NeededChannel:
    """A channel that an analysis cannot do without."""

    name: str
    """role.name; of a counter or label its name."""
    key: tuple[str | int, ...]
    """Where the settings name it, such as ('of',)."""
    enters: tuple[str, ...] = ()
    """The results that its values enter."""
    or_coordinate: bool = False
    """Whether a set-point, counter or label of that name serves where no such channel is read."""
    quantity: str = ""
    """The kind of quantity that it must be, such as 'voltage'; '' for any."""
    spans: tuple[float, float] | None = None
    """The least and the greatest value that it must reach, in the SI unit. It is asked of
    set-points: what is read is not known beforehand."""
    values: tuple[Quantity | str, ...] = ()
    """Values at each of which something must be measured; asked of set-points, counters and labels
    only."""
    shared: str = ""
    """A set-point, counter or label that must have one of its values, at least, at all `values`."""
    within: float = 0.0
    """By how much values of `shared` may differ to count as one, as a share of their range."""
    x_of: str = ""
    """Of the x of a fit, the field of the settings that names the fit: as many different set-points
    are asked for as that fit needs."""


@dataclass(frozen=True, kw_only=True)
class NeededResult:
    """A result of another analysis, which is made first."""

    name: str
    key: tuple[str | int, ...]
    """Where the settings name it, such as ('inputs', 'R')."""
    per: tuple[str, ...] | None = None
    """The only coordinates that may tell its values apart; None: any."""
    independent: bool = False
    """Whether it counts as independent of the others, but for the lines that their budgets share:
    two such results of one analysis are refused, as their scatter is one."""


def partner_words(name: str) -> str:
    """Return a partner run in words: 'dark' is the dark run, 'dark_after' the dark run after it."""
    before = name.removesuffix(_AFTER)
    return f"{before.replace('_', '-')} run{' after it' if before != name else ''}"


@dataclass(frozen=True, kw_only=True)
class NeededRun:
    """A partner run that an analysis cannot do without.

    It must be completed, and be no replay of a tape, unless this run is one too. Raises ValueError
    for a name that cannot be one.
    """

    name: str
    """By which the analysis has it, `run.partners[name]`, and people name one: letters, digits and
    '_'. One name is one run: analyses that use a name must ask for the same run by it."""
    key: tuple[str | int, ...]
    """Where the settings ask for it, such as ('tare',)."""
    procedure: str = ""
    """The id of the procedure that it must be a run of; '' for any."""
    run: str = LATEST
    """'latest', or a run by its folder or name."""
    max_age_s: float = 8 * _HOUR_S
    """How long before this run it may have begun; of one after it, how long after."""
    same: tuple[str, ...] = (STATION,)
    """What both must have in common: 'station', and keys of the rig."""
    after: bool = False
    """Whether it is made after this run, which is kept open until `resume` takes it in."""
    channels: tuple[NeededChannel, ...] = ()
    """What must be measured in it, in one step together; their keys are not used."""
    at: tuple[str, ...] = ()
    """Set-points, counters or labels: at each of their values in this run its channels must have
    been measured in it too."""
    within: float = 1e-6
    """How far, relatively, such a value of both may differ."""
    optional: bool = False
    """Whether the analysis is made without it too, and says itself what it then lacks."""

    def __post_init__(self) -> None:
        """Refuse a name that cannot be one."""
        if not re.fullmatch(NAME, self.name) or self.name in _FILES:
            raise ValueError(f"'{self.name}' cannot be the name of a partner run")

    @property
    def words(self) -> str:
        """It in words, such as 'dark run'."""
        return partner_words(self.name)


@dataclass(frozen=True, kw_only=True)
class Requirements:
    """What an analysis, an outlier rule or a fit needs, from its settings alone.

    The defaults ask for nothing.
    """

    channels: tuple[NeededChannel, ...] = ()
    """What must be measured, in one step together."""
    results: tuple[NeededResult, ...] = ()
    """Results of other analyses of the procedure: these are made first."""
    partners: tuple[NeededRun, ...] = ()
    """Other runs that it is given beside this one."""
    cycles: int = 0
    """Whole cycles in each recording."""
    rate_hz: float = 0.0
    """Samples per second, in each recording of its channels."""
    points: int = 0
    """Different x of the values that a fit is through."""
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Of a fit, its parameters, each with its unit in SI, or '' where that follows from the points;
    empty where the settings alone do not tell them."""
