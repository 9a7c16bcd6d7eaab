"""Input of an analysis in addition to its settings, if it requests it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.progress import Progress, unseen

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.analysis.requirements import Requirements
    from rigrunner.api.hooks import PluginRecord


class Plugins(Protocol):
    """Other plugins, by kind and name."""

    def make(self, kind: str, name: str, settings: Mapping[str, Any]) -> Any:
        """Return the object that a plugin's factory makes, such as a fit; raise PluginError.

        The object is checked first.
        """
        ...

    def record(self, kind: str, name: str) -> PluginRecord:
        """Return what a plugin declares; raise PluginError if there is no such plugin."""
        ...

    def requires(self, kind: str, name: str, settings: Mapping[str, Any]) -> Requirements:
        """Return the requirements of a plugin with these settings; raise PluginError."""
        ...


@dataclass(frozen=True, kw_only=True)
class AnalysisContext:
    """The plugins that the settings may name, and data of the procedure outside the analysis.

    Given to the functions of an AnalysisRecord with `in_context`.
    """

    plugins: Plugins
    measurand: str = ""
    """The measurand of the procedure in words; '' if not stated."""
    symbol: str = ""
    """Its symbol."""
    progress: Progress = unseen
    """Callback for the progress of long calculations; an exception of it ends the analysis."""
    interim: bool = False
    """Whether the run is in progress: long calculations are then omitted."""
