"""What an analysis of any quantity takes and gives: named measurement results (VIM 2.9)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from rigrunner.api.coordinates import place_text

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.analysis import Check, Component
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.data import Block, Estimate, Recording, RunData
    from rigrunner.api.details import AnalysisDetails
    from rigrunner.api.figures import Curve, Figure, Picture
    from rigrunner.api.measurand import MeasurandKind


@dataclass(frozen=True, kw_only=True)
class ResultDefinition:
    """The definition of a result, known from the settings alone."""

    name: str
    """By which limits, documents and other analyses name it."""
    symbol: str = ""
    """Such as R; '' for none."""
    text: str = ""
    """The measurand in words (VIM 2.3), such as 'load regulation'."""
    unit: str
    """In which it is stated."""
    per: tuple[str, ...] = ()
    """The coordinates that tell its results apart; none: there is one result."""
    id: str = ""
    """The measurand for programs; '' where the analysis is not told one."""
    measurand: MeasurandKind | None = None
    """Which torque it is, of a torque whose method says so; a limit of another one is refused."""

    @property
    def words(self) -> str:
        """The measurand in words, or else its name."""
        return self.text or self.name


@dataclass(frozen=True, kw_only=True)
class MeasurementResult:
    """One value of a named result, with its uncertainty, and where it holds (VIM 2.9)."""

    of: ResultDefinition
    estimate: Estimate
    """In the unit of the definition."""
    components: tuple[Component, ...] = ()
    """Its budget, in the same unit; empty where nothing is known of its uncertainty."""
    coordinates: Mapping[str, CoordinateValue] = field(default_factory=dict)
    """A value for each coordinate of `of.per`."""
    readings: int = 1
    """How many values it was made of."""
    uncorrected: Estimate | None = None
    """The same before the correction that it is for, judged beside it; None where none is made."""

    @property
    def name(self) -> str:
        """That of the definition."""
        return self.of.name

    @property
    def place(self) -> str:
        """Where it holds, in words: 'load.current = 2 A'; '' for the only one."""
        return place_text(self.coordinates)


@dataclass(frozen=True, kw_only=True)
class Formula:
    """An equation by which a result was computed, as the report sets it."""

    of: str = ""
    """The name of the result with which it stands; '' in a section."""
    symbol: str
    """What it gives: the left side."""
    text: str
    """The right side, in the notation of `rigrunner.signal.expression`."""
    quantities: Mapping[str, str] = field(default_factory=dict)
    """What names in it stand for that are numbers with a unit, such as {'number_1': '0 °C'}."""


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table that belongs to results, in rows of numbers and texts."""

    of: str = ""
    """The name of the result with which it stands; '' in a section."""
    title: str
    columns: tuple[str, ...]
    """What each holds, with its unit where it has one: 'u / mm'."""
    rows: tuple[tuple[float | str, ...], ...]


@dataclass(frozen=True, kw_only=True)
class ReportSection:
    """A section of the report, as data; its parts stand in this order."""

    title: str
    paragraphs: tuple[str, ...] = ()
    formulas: tuple[Formula, ...] = ()
    figures: tuple[Figure | Picture, ...] = ()
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Findings:
    """What an analysis found in a run."""

    results: tuple[MeasurementResult, ...] = ()
    """Of each definition one, or one for each place."""
    means: tuple[MeasurementResult, ...] = ()
    """The mean over all places, of a definition whose analysis knows what the places share.

    It has no coordinates. Of any other definition the mean is taken by the budgets.
    """
    checks: tuple[Check, ...] = ()
    """What was looked at besides; one that is `decisive` and not `ok` forbids a verdict."""
    notes: tuple[str, ...] = ()
    """What a reader must know, in sentences."""
    formulas: tuple[Formula, ...] = ()
    """By which results were computed; the report shows them with the results."""
    tables: tuple[Table, ...] = ()
    """What belongs to results besides; in the report, and in `result.json`."""
    figures: tuple[Figure, ...] = ()
    """Likewise, drawn in the report."""
    sections: tuple[ReportSection, ...] = ()
    """Of the report, after the results; in `result.json` too."""
    details: tuple[AnalysisDetails, ...] = ()
    """What the analysis keeps besides, for pages and programs that know it."""


class Analysis(Protocol):
    """Makes results of a run; it changes nothing, asks no clock, and reads no file."""

    def __call__(self, run: RunData) -> Findings:
        """Return what was found; raise DataError where the run lacks what is required.

        `run.partners` has the partner runs that it requires, by name.
        """
        ...


class AnalysisOfResults(Protocol):
    """The same of an analysis that needs results of others: it is given those that it names."""

    def __call__(self, run: RunData, results: Sequence[MeasurementResult]) -> Findings:
        """Return what was found; raise DataError where the run or the results lack something."""
        ...


class LiveAnalysis(Protocol):
    """What an analysis shows while it is measured: a fold over blocks, in bounded memory.

    What it shows of a whole recording is what the analysis finds of it, however the blocks are cut.
    """

    def begin(self, recording: Recording, run: RunData) -> None:
        """Begin with a recording: all of it but its samples.

        One that is not kept has no name: its curves are shown, and it enters no result. `run` is
        the run that it belongs to, without recordings: its rig, instruments, zero readings and
        partner runs, as far as they are known.
        """
        ...

    def take(self, block: Block) -> Sequence[Curve]:
        """Take the next block of that recording; return the curves that it completes, or none.

        A screen shows them at once. Its channels, 'role.name', have readings in SI units: zero
        readings are taken off, and what a certificate corrects is corrected, as `RunData.readings`
        does.
        """
        ...

    def findings(self) -> Findings:
        """Return what is known by now. An uncertainty that only the whole run tells is nan.

        It is asked for a few times a second: what takes long is done here, not in `take`.
        """
        ...


Objection = tuple[tuple[str | int, ...], str, str] | tuple[tuple[str | int, ...], str, str, int]
"""A key of the settings, what is wrong with what stands there, and what to write instead.

With a number: which character of the text that stands there is meant, from 1.
"""
