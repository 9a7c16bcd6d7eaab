"""Studies of many runs, as calculated by their commands and shown in their reports.

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
    """The value of one run, and its expanded uncertainty (95 %) if stated."""

    run_id: str
    started_utc: datetime
    value: float
    expanded: float | None = None


@dataclass(frozen=True)
class Excluded:
    """A run that is excluded from a study, and why."""

    run_id: str
    reason: str


@dataclass(frozen=True)
class Limits:
    """The centre of a chart, its limits, and the standard deviation behind them."""

    centre: float
    sigma: float
    lower: float
    upper: float


@dataclass(frozen=True)
class ChartPoint:
    """A run on a chart: plotted value, limits, and the rules that it violates."""

    observed: Observed
    baseline: bool
    """Whether it was used to calculate the limits (phase I)."""
    plotted: float
    """The value, or the EWMA at it."""
    lower: float
    upper: float
    moving_range: float | None
    """Relative to the previous value; None for the first."""
    rules: tuple[str, ...] = ()


@dataclass(frozen=True)
class TrendSeries:
    """The chart of one group of runs, oldest first."""

    name: str
    points: tuple[ChartPoint, ...]
    individuals: Limits
    moving_range: Limits
    lag_one: float
    """Lag-1 autocorrelation within the baseline."""
    warnings: tuple[str, ...] = ()

    @property
    def after(self) -> tuple[ChartPoint, ...]:
        """Points after the baseline (phase II)."""
        return tuple(point for point in self.points if not point.baseline)

    @property
    def alarms(self) -> tuple[ChartPoint, ...]:
        """Those of them that violate a rule."""
        return tuple(point for point in self.after if point.rules)


@dataclass(frozen=True)
class Index:
    """A capability index with its two-sided confidence interval."""

    name: str
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Capability:
    """The capability of a process: mean, standard deviation, and indices."""

    count: int
    mean: float
    standard_deviation: float
    confidence: float
    indices: tuple[Index, ...]
    mean_interval: tuple[float, float]
    deviation_interval: tuple[float, float]


@dataclass(frozen=True)
class CapabilitySeries:
    """The capability of one group of runs, with reservations."""

    name: str
    observed: tuple[Observed, ...]
    capability: Capability
    warnings: tuple[str, ...] = ()
    lower: float | None = None
    """The limits: those requested, or else those of the runs."""
    upper: float | None = None


@dataclass(frozen=True)
class Row:
    """A row of the analysis of variance."""

    source: str
    degrees_of_freedom: int
    sum_of_squares: float
    mean_square: float
    f: float | None = None
    p: float | None = None


@dataclass(frozen=True)
class Components:
    """Standard deviations of the components of a reading, in the unit of the readings."""

    repeatability: float
    operator: float
    interaction: float
    part: float

    @property
    def reproducibility(self) -> float:
        """Of operators, including their interaction with the parts."""
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
        """Number of distinct categories, not rounded down."""
        return DISTINCT * self.part / self.gauge if self.gauge > 0.0 else float("inf")


@dataclass(frozen=True)
class Known:
    """The uncertainty of a component of a gauge study."""

    low: float
    """Confidence interval, as standard deviations."""
    high: float
    confidence: float
    degrees_of_freedom: float
    """By Satterthwaite; 0 if the component is 0."""


@dataclass(frozen=True)
class GaugeAnalysis:
    """The table of a gauge study, whether the interaction was pooled, and the components."""

    table: tuple[Row, ...]
    pooled: bool
    components: Components
    known: Mapping[str, Known] = field(default_factory=dict)
    """By name of the component; without a pooled interaction."""


@dataclass(frozen=True, kw_only=True)
class Study:
    """Common part of all studies: the quantity and the runs."""

    quantity: str
    unit: str
    asked: Mapping[str, str]
    """The selection as text, by name."""
    excluded: tuple[Excluded, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Trend(Study):
    """Control charts of a quantity, one for each group of runs."""

    chart: str
    """'i-mr' or 'ewma'."""
    rules: Mapping[str, str]
    """The applied rules by name, as text."""
    series: tuple[TrendSeries, ...]
    not_charted: Mapping[str, str] = field(default_factory=dict)
    """Groups without a chart, and why."""


@dataclass(frozen=True, kw_only=True)
class CapabilityStudy(Study):
    """The capability of a quantity against its limits, for each group of runs."""

    lower: float | None
    """The requested limits; without any each group has its own."""
    upper: float | None
    series: tuple[CapabilitySeries, ...]
    not_stated: Mapping[str, str] = field(default_factory=dict)
    """Groups without capability, and why."""


@dataclass(frozen=True, kw_only=True)
class GaugeStudy(Study):
    """A crossed study of the repeatability and reproducibility of a gauge."""

    parts: tuple[str, ...]
    operators: tuple[str, ...]
    readings: tuple[tuple[tuple[float, ...], ...], ...]
    """Of shape (parts, operators, trials)."""
    analysis: GaugeAnalysis
    tolerance: float | None = None
    """Upper limit minus lower limit, to which the gauge is compared."""
    expanded: float | None = None
    """Median stated expanded uncertainty (95 %) of a reading, if stated."""

    @property
    def trials(self) -> int:
        """Number of readings of each part by each operator."""
        return len(self.readings[0][0])


@dataclass(frozen=True)
class Shift:
    """Shift of the results at one set-point, over all golden runs."""

    frequency_hz: float
    count: int
    mean_nm: float
    deviation_nm: float | None
    """Standard deviation; None for a single one."""
    mean_in_u: float | None
    """Relative to expanded uncertainties (95 %) of the references; None without any."""
    largest_in_u: float | None
    """The shift with the greatest amount, with its sign."""


@dataclass(frozen=True)
class GoldenRun:
    """A golden run: comparison with its reference, present verdict, and differences as text."""

    name: str
    standing: str
    moved: bool
    """Whether a person must look at it."""
    verdict: str
    lines: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class GoldenStudy(Study):
    """Stored raw data, analysed with other software or settings and compared with references."""

    tolerance: float
    """Relative to expanded uncertainties of the references."""
    counts: tuple[tuple[str, bool, int], ...]
    """Number of runs by state: the state, whether it is a shift, the number."""
    flips: tuple[tuple[str, str, int], ...]
    """Verdict of the reference, present verdict, number of runs."""
    shifts_in_u: tuple[float, ...]
    """Shift of the result of each run."""
    set_points: tuple[Shift, ...]
    runs: tuple[GoldenRun, ...]
    """Runs, the most serious first."""


StudyInput = Trend | CapabilityStudy | GaugeStudy | GoldenStudy
"""The input of a study format."""
