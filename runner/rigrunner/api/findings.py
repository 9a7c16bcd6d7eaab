"""What an analysis takes and returns: named measurement results (VIM 2.9)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from rigrunner.api.coordinates import place_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigrunner.api.analysis import Check, Component
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.data import Block, Estimate, Recording, RunData
    from rigrunner.api.details import AnalysisDetails
    from rigrunner.api.figures import Curve, Figure, Picture
    from rigrunner.api.measurands import ResultMeasurand


@dataclass(frozen=True, kw_only=True)
class ResultDefinition:
    """The definition of a result, known from the settings alone."""

    name: str
    """Name for limits, documents and other analyses."""
    symbol: str = ""
    """Such as R; '' for none."""
    text: str = ""
    """Description of the measurand (VIM 2.3), such as 'load regulation'."""
    unit: str
    """Unit of the result."""
    per: tuple[str, ...] = ()
    """Coordinates that distinguish its values; empty for a single one."""
    id: str = ""
    """Identifier of the measurand for programs; '' if not stated."""
    measurand: ResultMeasurand | None = None
    """Which quantity it is, where an analysis yields several of one unit; limits of another one are
    refused."""

    @property
    def words(self) -> str:
        """The description of the measurand, or its name."""
        return self.text or self.name

    @property
    def title(self) -> str:
        """The description with a capital letter, or the name as it is: 'V' may be another one."""
        return f"{self.text[:1].upper()}{self.text[1:]}" or self.name


@dataclass(frozen=True, kw_only=True)
class ResultPlace:
    """A named result and one of its places."""

    of: ResultDefinition
    coordinates: Mapping[str, CoordinateValue] = field(default_factory=dict)
    """A value for each coordinate of `of.per`."""

    @property
    def name(self) -> str:
        """Name of the definition."""
        return self.of.name

    @property
    def place(self) -> str:
        """The place as text: 'load.current = 2 A'; '' for the only one."""
        return place_text(self.coordinates)


@dataclass(frozen=True, kw_only=True)
class MeasurementResult(ResultPlace):
    """One value of a named result, with its uncertainty and its place (VIM 2.9)."""

    estimate: Estimate
    """In the unit of the definition."""
    components: tuple[Component, ...] = ()
    """Uncertainty budget, in the same unit; empty if the uncertainty is unknown."""
    readings: int = 1
    """Number of values that it was calculated from."""
    uncorrected: Estimate | None = None
    """The uncorrected value, judged beside it; None without a correction."""


@dataclass(frozen=True, kw_only=True)
class MissingResult(ResultPlace):
    """A place at which a named result has no value, such as a quotient whose divisor is 0.

    A limit on the result there, or on its mean, is inconclusive.
    """

    why: str
    """The reason, to follow a colon: 'U / I gives no finite number'."""

    @property
    def sentence(self) -> str:
        """What is missing, where and why, in one sentence."""
        where = f" at {self.place}" if self.place else ""
        return f"There is no value of {self.name}{where}: {self.why}."


@dataclass(frozen=True, kw_only=True)
class Formula:
    """An equation of a result, as the report typesets it."""

    of: str = ""
    """Name of the result that it is shown with; '' in a section."""
    symbol: str
    """The left side."""
    text: str
    """The right side, in the notation of `rigrunner.signal.expression`."""
    quantities: Mapping[str, str] = field(default_factory=dict)
    """Names in it that stand for a number with a unit, such as {'number_1': '0 °C'}."""
    is_curve: bool = False
    """Whether it is a fitted curve, of which the result is derived. A certificate leaves it out."""


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of numbers and texts for results."""

    of: str = ""
    """Name of the result that it is shown with; '' in a section."""
    title: str
    columns: tuple[str, ...]
    """Heads of the columns, with units: 'u / mm'."""
    rows: tuple[tuple[float | str, ...], ...]


@dataclass(frozen=True, kw_only=True)
class ReportSection:
    """A section of the report as data; its parts are shown in this order."""

    title: str
    paragraphs: tuple[str, ...] = ()
    formulas: tuple[Formula, ...] = ()
    figures: tuple[Figure | Picture, ...] = ()
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Findings:
    """What an analysis found in a run."""

    results: tuple[MeasurementResult, ...] = ()
    """One for each definition, or one for each place."""
    missing: tuple[MissingResult, ...] = ()
    """Places at which a result has no value, instead of a result there."""
    means: tuple[MeasurementResult, ...] = ()
    """Means over all places, of definitions whose analysis knows what the places have in common.

    They have no coordinates. The means of other definitions are calculated from the budgets.
    """
    checks: tuple[Check, ...] = ()
    """Further checks; one that is `decisive` and not `ok` makes the verdict inconclusive."""
    notes: tuple[str, ...] = ()
    """Notes for the reader, in sentences."""
    formulas: tuple[Formula, ...] = ()
    """Equations, shown in the report with the results."""
    tables: tuple[Table, ...] = ()
    """Tables for results, in the report and in `result.json`."""
    figures: tuple[Figure, ...] = ()
    """Figures for results, in the report."""
    sections: tuple[ReportSection, ...] = ()
    """Report sections after the results; also in `result.json`."""
    details: tuple[AnalysisDetails, ...] = ()
    """Further record of the analysis, for its own pages and programs."""


class Analysis(Protocol):
    """Calculates results of a run. It changes nothing, reads no clock and no file."""

    def __call__(self, run: RunData) -> Findings:
        """Return the findings; raise DataError if required data are missing.

        `run.partners` has the required partner runs by name.
        """
        ...


class AnalysisOfResults(Protocol):
    """An Analysis that requires results of others, and is called with them."""

    def __call__(
        self,
        run: RunData,
        results: Sequence[MeasurementResult],
        missing: Sequence[MissingResult],
    ) -> Findings:
        """Return the findings; raise DataError if required data or results are missing.

        `missing` are the places at which a required result has no value.
        """
        ...


class LiveAnalysis(Protocol):
    """The live view of an analysis during a measurement: a fold over blocks, in bounded memory.

    For a complete recording it shows the findings of the analysis, with blocks of any size;
    for one longer than it can keep, those of its latest part. Blocks may be missing.
    """

    def begin(self, recording: Recording, run: RunData) -> None:
        """Start a recording, given without its samples.

        A recording without a name is not kept: its curves are shown, but it does not contribute to
        results. `run` has the rig, instruments, zero readings and partner runs as far as known, and
        no recordings.
        """
        ...

    def take(self, block: Block) -> Sequence[Curve]:
        """Take the next block of the recording; return the curves that it completes.

        They are displayed at once. Channels, 'role.name', are in SI units, minus zero readings and
        corrected by certificates, as by `RunData.readings`.
        """
        ...

    def findings(self) -> Findings:
        """Return the findings so far. An uncertainty that needs the whole run is nan.

        Called a few times per second: do lengthy calculations here, not in `take`.
        """
        ...


@runtime_checkable
class SnapshotAnalysis(LiveAnalysis, Protocol):
    """A live view whose findings take so long that its curves would be late."""

    def snapshot(self) -> Callable[[], Findings]:
        """Return a function that makes the findings so far.

        It is called in another thread while the next blocks are taken, and a snapshot is taken only
        when the one before was made. So it may use what no other method uses, and what it got here.
        """
        ...


Objection = tuple[tuple[str | int, ...], str, str] | tuple[tuple[str | int, ...], str, str, int]
"""A key of the settings, what is wrong with its value, and a hint.

With a number: the character in the text that it refers to, from 1.
"""
