"""What an analysis is given beside its settings, where it asks for that."""

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
        """Return what a plugin's factory makes, such as a fit; raise PluginError.

        What it gives is checked before the analysis gets it.
        """
        ...

    def record(self, kind: str, name: str) -> PluginRecord:
        """Return what a plugin declares; raise PluginError if there is no such plugin."""
        ...

    def requires(self, kind: str, name: str, settings: Mapping[str, Any]) -> Requirements:
        """Return what a plugin needs of a run with these settings; raise PluginError."""
        ...


@dataclass(frozen=True, kw_only=True)
class AnalysisContext:
    """The plugins that the settings may name, and what the procedure says beside the analysis.

    Given to the functions of an AnalysisRecord with `in_context`.
    """

    plugins: Plugins
    measurand: str = ""
    """What the procedure measures, in words; '' where it does not say."""
    symbol: str = ""
    """Its symbol."""
    progress: Progress = unseen
    """Is told how far what takes minutes is; what it raises ends the analysis."""
    interim: bool = False
    """Whether the run continues: what takes minutes is left out then."""
