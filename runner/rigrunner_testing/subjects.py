"""The subject of checks: one plugin with its settings, created as often as a check needs it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner_testing.check import NotApplicable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.hooks import PluginRecord
    from rigrunner.registry import Plugin, Registry

RecordT = TypeVar("RecordT")


@dataclass(frozen=True)
class Subject:
    """One plugin of a registry; the settings have the form of YAML."""

    plugin: Plugin
    registry: Registry
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """The kind of plugin, such as 'device'."""
        return self.plugin.kind

    @property
    def name(self) -> str:
        """The plugin's name in YAML."""
        return self.plugin.record.name

    @property
    def any_record(self) -> PluginRecord:
        """What the plugin declares."""
        return self.plugin.record

    @property
    def simulated(self) -> bool:
        """Whether there is no instrument."""
        return True

    def make(self, **changes: Any) -> Any:
        """Return a new plugin with the settings and the changes; raise PluginError."""
        return self.registry.make(self.kind, self.name, {**self.settings, **changes})

    @cached_property
    def made(self) -> Any:
        """One plugin for all checks that do not change it."""
        return self.make()

    def record_as(self, kind: type[RecordT]) -> RecordT:
        """Return the record as one of that type."""
        if not isinstance(self.plugin.record, kind):
            raise NotApplicable(f"{type(self.plugin.record).__name__} is not a {kind.__name__}")
        return self.plugin.record

    def release(self) -> None:
        """Release what a check left open, such as devices."""
