"""A command group that imports a command only when it is called."""

from __future__ import annotations

import difflib
from functools import cached_property
from importlib import import_module
from keyword import iskeyword
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import click

from rigrunner.cli.output import result
from rigrunner.cli.package_commands import Commands

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping


class LazyGroup(click.Group):
    """Commands in groups, each with a line of help; a command is `<package>.<name>.command`.

    The lines of help are not in the modules, so that `--help` imports none of them. In module names
    a hyphen becomes an underscore, and a keyword such as `import` gets one at its end. Commands of
    other packages are looked up only if the name is not one of our own, and cannot replace one.
    """

    def __init__(
        self,
        *,
        own: Commands,
        others: Callable[[], Iterable[Commands]] = tuple,
        renamed: Mapping[str, str] = MappingProxyType({}),
        **settings: Any,
    ) -> None:
        super().__init__(**settings)
        self.own = own
        self._others = others
        self._renamed = renamed

    @cached_property
    def sources(self) -> tuple[Commands, ...]:
        """Our own commands and those of other packages."""
        return (self.own, *self._others())

    @cached_property
    def groups(self) -> dict[str, dict[str, str]]:
        """The line of help of each command by name, by title of the group."""
        groups: dict[str, dict[str, str]] = {}
        taken: set[str] = set()
        for source in self.sources:
            for title, commands in source.groups.items():
                new = {name: line for name, line in commands.items() if name not in taken}
                groups.setdefault(title, {}).update(new)
            taken |= source.names
        return {title: group for title, group in groups.items() if group}

    @property
    def summaries(self) -> dict[str, str]:
        """The line of help of each command by name, in the order of the help."""
        return {name: line for group in self.groups.values() for name, line in group.items()}

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002  (click's signature)
        """Return the names in the order of the help."""
        return list(self.summaries)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002  (click's signature)
        """Import and return a command; None if the name is unknown."""
        if cmd_name in self.own.names:
            source = self.own
        else:
            source = next((each for each in self.sources if cmd_name in each.names), self.own)
        if cmd_name not in source.names:
            return None
        module = cmd_name.replace("-", "_") + ("_" if iskeyword(cmd_name) else "")
        command = import_module(f"{source.package}.{module}").command
        assert isinstance(command, click.Command)  # noqa: S101  (narrows what import_module gives)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; raise UsageError with a suggestion for an unknown one."""
        if args[0] in self.own.names or args[0] in self.summaries:
            return super().resolve_command(ctx, args)
        if args[0] in self._renamed:
            new_name = self._renamed[args[0]]
            raise click.UsageError(f"The command '{args[0]}' is called '{new_name}' now.", ctx)
        matches = difflib.get_close_matches(args[0], self.summaries, n=1, cutoff=0.5)
        hint = f" Did you mean '{matches[0]}'?" if matches else ""
        raise click.UsageError(f"No such command '{args[0]}'.{hint}", ctx)

    def shell_complete(
        self, ctx: click.Context, incomplete: str
    ) -> list[click.shell_completion.CompletionItem]:
        """Return the matching commands and options without importing any command."""
        commands = [
            click.shell_completion.CompletionItem(name, help=help_line)
            for name, help_line in self.summaries.items()
            if name.startswith(incomplete)
        ]
        return commands + click.Command.shell_complete(self, ctx, incomplete)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002  (click's signature)
        """Write the list of commands without importing any."""
        widest = max(map(len, self.summaries))  # the same column in every group
        for title, group in self.groups.items():
            with formatter.section(title):
                formatter.write_dl([(name.ljust(widest), line) for name, line in group.items()])


def lazy_group(name: str, package: str, summaries: Mapping[str, str], text: str) -> LazyGroup:
    """Return a group of commands that shows its help if no command is given."""

    @click.group(
        name=name,
        cls=LazyGroup,
        invoke_without_command=True,
        own=Commands(package, {"Commands": summaries}),
        help=text,
    )
    @click.pass_context
    def group(context: click.Context) -> None:
        if context.invoked_subcommand is None:
            result(context.get_help())

    assert isinstance(group, LazyGroup)  # noqa: S101  (narrows what click gives)
    return group
