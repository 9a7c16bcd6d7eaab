"""Records of analyses in addition to their results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.analysis import Check
    from rigrunner.api.certificate import CertifiedDetails
    from rigrunner.api.data import Array, RunData
    from rigrunner.api.measurands import LimitedMeasurand


@dataclass(frozen=True, eq=False)
class PlotColumn:
    """A column of a plot, shape (n,)."""

    values: Array
    unit: str
    long_name: str
    """Label of the axis: 'frequency / Hz'."""


@dataclass(frozen=True, eq=False, kw_only=True)
class RunPlot:
    """The default plot of an analysed run in viewers of HDF5 files (NXdata)."""

    name: str
    """Name of its group in the file."""
    title: str
    columns: Mapping[str, PlotColumn]
    """By name; `NAME_errors` has the standard uncertainties of NAME."""
    axis: str
    """The column of the axis."""
    signal: str
    """The main column."""
    beside: tuple[str, ...] = ()
    """Columns that are plotted with it."""


class AnalysisDetails:
    """Base class of the record of one analysis in `Findings.details`.

    Reports and notebooks for an analysis find it by class: `result.details_of(...)`. All members
    have defaults.
    """

    @property
    def shown_results(self) -> frozenset[str]:
        """Names of results that the pages of this analysis show.

        A decision on one of them states only its place.
        """
        return frozenset()

    @property
    def shows_recordings(self) -> bool:
        """Whether its pages show the recordings and tables."""
        return False

    @property
    def checks_by_method(self) -> Mapping[str, tuple[Check, ...]]:
        """The checks of each method; those of the run are in `Findings.checks`."""
        return {}

    @property
    def method_checks(self) -> tuple[Check, ...]:
        """The checks of the method whose result counts."""
        return ()

    @property
    def corrects(self) -> bool:
        """Whether its results are corrected, and judged beside the uncorrected ones."""
        return False

    @property
    def undecided(self) -> str:
        """Why nothing can be decided on its results, as a sentence; '' if it can."""
        return ""

    def objection(self, limited: LimitedMeasurand | None) -> str:
        """Return why a limit for this measurand applies to none of its results; '' if it does.

        Called only for `shown_results`.
        """
        del limited
        return ""

    def impossible(self, value: float, unit: str) -> str:
        """Return why a value is impossible for its results, as a sentence; '' if it is possible."""
        del value, unit
        return ""

    def settings(self) -> Mapping[str, object]:
        """Return how documents record the settings of the analysis; plain values.

        Empty: as the procedure has them, with the defaults.
        """
        return {}

    def document(self) -> Mapping[str, object]:
        """Return its part of `result.json` by key; plain values."""
        return {}

    def plot(self) -> RunPlot | None:
        """Return the default plot of `run.h5`; None for another one."""
        return None

    def certified(self, run: RunData) -> CertifiedDetails | None:
        """Return its part of a certificate of a run; None for none.

        Raises DataError if it has no result for a certificate.
        """
        del run
        return None
