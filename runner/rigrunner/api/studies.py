"""Studies over many runs, as their commands find them and their reports show them.

Values are in the unit of the study, an SI unit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping
    from datetime import datetime

DISTINCT = sqrt(2.0)
"""ndc = 1.41 PV / GRR (AIAG, Measurement Systems Analysis, chapter III)."""


@dataclass(frozen=True)
class Observed:
    """What one run found: the value, and its expanded uncertainty (95 %) where it is stated."""

    run_id: str
    started_utc: datetime
    value: float
    expanded: float | None = None


@dataclass(frozen=True)
class Excluded:
    """A run that is not in a study, and why."""

    run_id: str
    reason: str


@dataclass(frozen=True)
class Limits:
    """The centre of a chart, its limits, and the standard deviation that they stand for."""

    centre: float
    sigma: float
    lower: float
    upper: float


@dataclass(frozen=True)
class ChartPoint:
    """A run on a chart: what is plotted, its limits, and the rules that are met there."""

    observed: Observed
    baseline: bool
    """Whether the limits were made of it, with others (phase I)."""
    plotted: float
    """The value itself, or the EWMA up to it."""
    lower: float
    upper: float
    moving_range: float | None
    """From the value before it; None for the first."""
    rules: tuple[str, ...] = ()


@dataclass(frozen=True)
class TrendSeries:
    """The chart of one group of runs, oldest first."""

    name: str
    points: tuple[ChartPoint, ...]
    individuals: Limits
    moving_range: Limits
    lag_one: float
    """Autocorrelation of neighbours within the baseline."""
    warnings: tuple[str, ...] = ()

    @property
    def after(self) -> tuple[ChartPoint, ...]:
        """The points beyond the baseline (phase II)."""
        return tuple(each for each in self.points if not each.baseline)

    @property
    def alarms(self) -> tuple[ChartPoint, ...]:
        """Those of them at which a rule is met."""
        return tuple(each for each in self.after if each.rules)


@dataclass(frozen=True)
class Index:
    """A capability index with the ends of its two-sided confidence interval."""

    name: str
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Capability:
    """What a process is capable of: its mean, its standard deviation, and the indices."""

    count: int
    mean: float
    standard_deviation: float
    confidence: float
    indices: tuple[Index, ...]


@dataclass(frozen=True)
class CapabilitySeries:
    """The capability of one group of runs, with what speaks against it."""

    name: str
    observed: tuple[Observed, ...]
    capability: Capability
    warnings: tuple[str, ...] = ()
    lower: float | None = None
    """The limits against which it is stated: those that were asked for, or else the runs' own."""
    upper: float | None = None


@dataclass(frozen=True)
class Row:
    """A row of the table of an analysis of variance."""

    source: str
    degrees_of_freedom: int
    sum_of_squares: float
    mean_square: float
    f: float | None = None
    p: float | None = None


@dataclass(frozen=True)
class Components:
    """Standard deviations of what a reading consists of, in the unit of the readings."""

    repeatability: float
    operator: float
    interaction: float
    part: float

    @property
    def reproducibility(self) -> float:
        """Of operators, their interaction with the parts included."""
        return sqrt(self.operator**2 + self.interaction**2)

    @property
    def gauge(self) -> float:
        """Repeatability and reproducibility together."""
        return sqrt(self.repeatability**2 + self.reproducibility**2)

    @property
    def total(self) -> float:
        """The gauge and the parts together."""
        return sqrt(self.gauge**2 + self.part**2)

    @property
    def distinct_categories(self) -> float:
        """The number of categories that the gauge can tell apart, not rounded down."""
        return DISTINCT * self.part / self.gauge if self.gauge > 0.0 else float("inf")


@dataclass(frozen=True)
class Known:
    """How well a component of a gauge study is known."""

    low: float
    """The ends of its confidence interval, as standard deviations."""
    high: float
    confidence: float
    degrees_of_freedom: float
    """By Satterthwaite; 0 where the component was found to be 0."""


@dataclass(frozen=True)
class GaugeAnalysis:
    """The full table of a gauge study, whether the interaction was pooled, the components."""

    table: tuple[Row, ...]
    pooled: bool
    components: Components
    known: Mapping[str, Known] = field(default_factory=dict)
    """By the names of the components; a pooled interaction is not among them."""


@dataclass(frozen=True, kw_only=True)
class Study:
    """What every study says: of what it is, and of which runs."""

    quantity: str
    unit: str
    asked: Mapping[str, str]
    """What was asked for, in words, by name."""
    excluded: tuple[Excluded, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Trend(Study):
    """Control charts of a quantity, one for each group of runs."""

    chart: str
    """'i-mr' or 'ewma'."""
    rules: Mapping[str, str]
    """The rules that were applied, by name, in words."""
    series: tuple[TrendSeries, ...]
    not_charted: Mapping[str, str] = field(default_factory=dict)
    """Groups without a chart, and why."""


@dataclass(frozen=True, kw_only=True)
class CapabilityStudy(Study):
    """The capability of a quantity against its limits, for each group of runs."""

    lower: float | None
    """The limits that were asked for; without any each group has its own."""
    upper: float | None
    series: tuple[CapabilitySeries, ...]
    not_stated: Mapping[str, str] = field(default_factory=dict)
    """Groups without a capability, and why."""


@dataclass(frozen=True, kw_only=True)
class GaugeStudy(Study):
    """A crossed study of the repeatability and reproducibility of a gauge."""

    parts: tuple[str, ...]
    operators: tuple[str, ...]
    readings: tuple[tuple[tuple[float, ...], ...], ...]
    """Of shape (parts, operators, trials)."""
    analysis: GaugeAnalysis
    tolerance: float | None = None
    """Upper limit less lower limit, to which the gauge is compared."""
    expanded: float | None = None
    """The median stated expanded uncertainty (95 %) of a reading, where there is one."""

    @property
    def trials(self) -> int:
        """How many readings there are of each part by each operator."""
        return len(self.readings[0][0])


@dataclass(frozen=True)
class Shift:
    """How the results at one set-point moved, over all golden runs."""

    frequency_hz: float
    count: int
    mean_nm: float
    deviation_nm: float | None
    """The standard deviation; None of a single one."""
    mean_in_u: float | None
    """In expanded uncertainties (95 %) of the references; None where they had none."""
    largest_in_u: float | None
    """The one that is farthest from 0, with its sign."""


@dataclass(frozen=True)
class GoldenRun:
    """A golden run: how it stands to its reference, its verdict now, and what differs, in words."""

    name: str
    standing: str
    moved: bool
    """Whether somebody has to look at it."""
    verdict: str
    lines: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class GoldenStudy(Study):
    """Stored raw data through other software or settings, against references."""

    tolerance: float
    """In expanded uncertainties of the references."""
    counts: tuple[tuple[str, bool, int], ...]
    """How many runs stand how: the standing, whether it is a move, how many."""
    flips: tuple[tuple[str, str, int], ...]
    """Verdict of the reference, verdict now, how many runs."""
    shifts_in_u: tuple[float, ...]
    """Of each run's result."""
    set_points: tuple[Shift, ...]
    runs: tuple[GoldenRun, ...]
    """The gravest first."""


StudyInput = Trend | CapabilityStudy | GaugeStudy | GoldenStudy
"""What a study format is given."""
