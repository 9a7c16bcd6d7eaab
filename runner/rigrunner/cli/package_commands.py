"""Commands of other packages, by entry points of the group `rigrunner.commands`.

An entry point names a package with a module for each command. Its `COMMANDS` has their help lines
by group, like `rigrunner.cli.main`, so that help and completion import none of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import EntryPoint, distributions
from typing import TYPE_CHECKING

from rigrunner.cli.output import message

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

GROUP = "rigrunner.commands"


@dataclass(frozen=True)
class Commands:
    """Commands whose modules are in one package."""

    package: str
    groups: Mapping[str, Mapping[str, str]]
    """The help line of each command by its name, by the title of its group."""

    @property
    def names(self) -> set[str]:
        """All their names."""
        return {name for group in self.groups.values() for name in group}


def package_commands() -> Iterator[Commands]:
    """Yield the commands of each installed package; one that cannot be imported is reported."""
    for name, entry in sorted(entries(GROUP).items()):
        try:
            groups = entry.load().COMMANDS
            yield Commands(entry.value, {title: dict(group) for title, group in groups.items()})
        except Exception as error:  # noqa: BLE001  (third-party code may raise anything)
            message(f"the commands of '{name}' cannot be loaded: {error}")


def entries(group: str) -> dict[str, EntryPoint]:
    """Return the entry points of a group by name. Only files that name the group are parsed."""
    return {
        entry.name: entry
        for distribution in distributions()
        if group in (distribution.read_text("entry_points.txt") or "")
        for entry in distribution.entry_points
        if entry.group == group
    }
