"""What an analysis keeps of its own beside its results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api.analysis import Check
    from rigrunner.api.certificate import CertifiedDetails
    from rigrunner.api.data import Array, RunData
    from rigrunner.api.measurand import MeasurandKind


@dataclass(frozen=True, eq=False)
class PlotColumn:
    """A column of a plot, shape (n,)."""

    values: Array
    unit: str
    long_name: str
    """As it stands at an axis: 'frequency / Hz'."""


@dataclass(frozen=True, eq=False, kw_only=True)
class RunPlot:
    """What a viewer of HDF5 files shows first of an analysed run, as NXdata has it."""

    name: str
    """Of its group in the file."""
    title: str
    columns: Mapping[str, PlotColumn]
    """By name; `NAME_errors` has the standard uncertainties of NAME."""
    axis: str
    """The column along which the others stand."""
    signal: str
    """The column that is drawn first."""
    beside: tuple[str, ...] = ()
    """Columns that are drawn with it."""


class LimitedMeasurand(Protocol):
    """The measurand that a limit is for, as its key `measurand` says; as text, in words."""

    def objection(self, found: MeasurandKind, loads_n: Iterable[float]) -> str:
        """Return why this is not the measurand that was found under those loads; '' if it is."""
        ...


class AnalysisDetails:
    """The record of one analysis: base class of what it gives in `Findings.details`.

    Reports and notebooks that know the analysis find it by its class: `result.details_of(...)`.
    Everything here may be left as it is.
    """

    @property
    def shown_results(self) -> frozenset[str]:
        """The names of those results that the pages of this analysis show themselves.

        A decision on one names its place alone.
        """
        return frozenset()

    @property
    def shows_recordings(self) -> bool:
        """Whether its pages show the recordings and tables themselves."""
        return False

    @property
    def checks_by_method(self) -> Mapping[str, tuple[Check, ...]]:
        """The checks of each method; those of the run itself stand in `Findings.checks`."""
        return {}

    @property
    def method_checks(self) -> tuple[Check, ...]:
        """The checks of that method alone whose result counts."""
        return ()

    @property
    def corrects(self) -> bool:
        """Whether its results are corrected, and judged beside what they were uncorrected."""
        return False

    @property
    def undecided(self) -> str:
        """Why nothing can be decided on its results, as a sentence; '' where it can."""
        return ""

    def objection(self, limited: LimitedMeasurand | None) -> str:
        """Return why a limit for this measurand is none of its results, as a sentence; '' if it is.

        Asked for the `shown_results` alone.
        """
        del limited
        return ""

    def impossible(self, value: float, unit: str) -> str:
        """Return why a value can be none of its results, as a sentence; '' where it can."""
        del value, unit
        return ""

    def document(self) -> Mapping[str, object]:
        """Return what it adds to `result.json`, by its keys there; plain values."""
        return {}

    def plot(self) -> RunPlot | None:
        """Return what a viewer of `run.h5` shows first; None leaves that to others."""
        return None

    def certified(self, run: RunData) -> CertifiedDetails | None:
        """Return what it adds to a certificate of a run; None: nothing.

        Raises DataError where it gave no result that a certificate could state.
        """
        del run
        return None
