"""Which providers of plugins are installed, by the entry points of all distributions."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points

from rigrunner.api.hooks import PROJECT


@dataclass(frozen=True)
class Installed:
    """A provider of plugins."""

    name: str
    place: str
    """The module that has its hooks, as an entry point gives it."""
    version: str
    """Of its distribution; '' for none."""

    @classmethod
    def of(cls, entry: EntryPoint) -> Installed:
        """Return the provider that an entry point gives."""
        return cls(entry.name, entry.value, entry.dist.version if entry.dist else "")

    @property
    def entry(self) -> EntryPoint:
        """What imports it."""
        return EntryPoint(self.name, self.place, PROJECT)


def installed() -> tuple[Installed, ...]:
    """Return all providers that are installed, by name."""
    entries = sorted(entry_points(group=PROJECT), key=lambda entry: entry.name)
    return tuple(Installed.of(entry) for entry in entries)
