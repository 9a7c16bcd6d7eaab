"""Installed providers of plugins, from the entry points of all distributions."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points

from rigrunner.api.hooks import PROJECT


@dataclass(frozen=True)
class Installed:
    """A provider of plugins."""

    name: str
    place: str
    """The module with its hooks, from the entry point."""
    version: str = ""
    """Of its distribution; '' for none."""
    distribution: str = ""
    """The name of its distribution; '' for none."""

    @classmethod
    def of(cls, entry: EntryPoint) -> Installed:
        """Return the provider of an entry point."""
        distribution = (entry.dist.version, entry.dist.name) if entry.dist else ()
        return cls(entry.name, entry.value, *distribution)

    @property
    def entry(self) -> EntryPoint:
        """The entry point that imports it."""
        return EntryPoint(self.name, self.place, PROJECT)


def installed() -> tuple[Installed, ...]:
    """Return all installed providers by name."""
    entries = sorted(entry_points(group=PROJECT), key=lambda entry: entry.name)
    return tuple(Installed.of(entry) for entry in entries)
