"""How the analysis finds the plugins that a procedure names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.fit_choice import chosen_fits

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.analysis import Fit, Requirements
    from rigrunner.api.analysis_context import AnalysisContext
    from rigrunner.api.findings import ResultDefinition
    from rigrunner.api.fit_choice import FitChoice
    from rigrunner.api.hooks import PluginRecord
    from rigrunner.api.settings import Settings


class Lookup(Protocol):
    """Finds plugins by kind and name."""

    def make(
        self,
        kind: str,
        name: str,
        settings: Mapping[str, Any],
        context: AnalysisContext | None = None,
        **fits: Fit,
    ) -> Any:
        """Return the callable of a kind such as 'fit' or 'decision_rule'; raise PluginError.

        `context` is that of an analysis; left out, it has no more than the plugins. `fits`: those
        that its settings name, by the fields that do.
        """
        ...

    def validated(self, kind: str, name: str, settings: Mapping[str, Any]) -> Settings:
        """Return the validated settings of a plugin; raise PluginError."""
        ...

    def record(self, kind: str, name: str) -> PluginRecord:
        """Return what a plugin declares; raise PluginError."""
        ...

    def definitions(
        self, name: str, settings: Mapping[str, Any], context: AnalysisContext | None = None
    ) -> tuple[ResultDefinition, ...]:
        """Return the results that an analysis names, given its settings; raise PluginError."""
        ...

    def requires(self, kind: str, name: str, settings: Mapping[str, Any]) -> Requirements:
        """Return what a plugin of the analysis needs of a run; raise PluginError."""
        ...

    def revision(self, kind: str, name: str) -> int:
        """Return the revision of an installed plugin; raise PluginError."""
        ...


def fits_in(lookup: Lookup, analysis: str, settings: Mapping[str, Any]) -> Mapping[str, FitChoice]:
    """Return the fits that the settings of an analysis name, by the fields that do."""
    return chosen_fits(lookup.validated("analysis", analysis, settings))
