"""How the analysis finds the plugins that a procedure names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.findings import ResultDefinition
    from rigrunner.api.measurand import MeasurandKind
    from rigrunner.api.settings import Settings


class Lookup(Protocol):
    """Finds plugins by kind and name."""

    def make(self, kind: str, name: str, settings: Mapping[str, Any]) -> Any:
        """Return the callable of a kind such as 'fit' or 'decision_rule'; raise PluginError."""
        ...

    def settings_of(self, kind: str, name: str) -> type[Settings]:
        """Return the settings model of a plugin; raise PluginError."""
        ...

    def yields(self, compensation: str) -> MeasurandKind | None:
        """Return which torque a compensation yields, if its plugin says."""
        ...

    def definitions(self, name: str, settings: Mapping[str, Any]) -> tuple[ResultDefinition, ...]:
        """Return the results that an analysis names, by its settings; raise PluginError."""
        ...

    def revision(self, kind: str, name: str) -> int:
        """Return the revision of an installed plugin; raise PluginError."""
        ...
