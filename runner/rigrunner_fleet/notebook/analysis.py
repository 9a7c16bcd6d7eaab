"""Analyse a run again, in a notebook."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner_fleet.notebook.rows import figures_of, plot_of, points_of, results_of, results_plot

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.results import Result
    from rigrunner.plots import Plot
    from rigrunner_fleet.archive import Rows
    from rigrunner_fleet.notebook.rows import Document


@dataclass(frozen=True, eq=False)
class Analysis:
    """The result of an analysis."""

    result: Result
    """The result, as in reports."""

    @cached_property
    def document(self) -> Document:
        """The same numbers, as in `result.json`."""
        from rigrunner.analysis.document import document  # noqa: PLC0415  (the analysis is heavy)

        return dict(document(self.result))

    @property
    def points(self) -> Rows:
        """A row for each set-point, as in the archive."""
        return points_of(self.document)

    @property
    def results(self) -> Rows:
        """A row for each named result, as in the archive."""
        return results_of(self.document)

    @property
    def figures(self) -> Rows:
        """The figures of the rig, as in the archive."""
        return figures_of(self.document)

    def plot_results(self, name: str) -> Plot:
        """Return the figures of a named result, as in the report; raise UsageError."""
        return results_plot(self.document, name)

    def plot(self) -> Plot:
        """Return torque over frequency."""
        return plot_of(self.document, self.result.run.run_id)


def analyse(
    run: Path | str,
    partners: Mapping[str, Path | str] | None = None,
    *,
    station: str | None = None,
) -> Analysis:
    """Analyse a stored run by its procedure, with the installed plugins.

    `partners`, by name, replace the partner runs in its file; `station` names one whose own plugins
    are needed. Nothing is written. Raises DataError if it cannot be analysed.
    """
    from rigrunner.run.lab_plugins import lab_registry  # noqa: PLC0415  (the analysis is heavy)
    from rigrunner.run.stored import analyse_run  # noqa: PLC0415  (the same)

    partner_paths = {name: Path(path) for name, path in (partners or {}).items()}
    return Analysis(analyse_run(Path(run), lab_registry(station), partner_paths))
