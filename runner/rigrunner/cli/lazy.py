"""A command group that imports a command only when it is called."""

from __future__ import annotations

import difflib
from importlib import import_module
from keyword import iskeyword
from typing import TYPE_CHECKING, Any

import click

from rigrunner.cli.output import result

if TYPE_CHECKING:
    from collections.abc import Mapping


class LazyGroup(click.Group):
    """Commands in groups, with their line of help; each lives in `<package>.<name>` as `command`.

    The lines of help stand here, not in the modules, so that `--help` imports none of them. The
    module of a name with a hyphen has an underscore there; that of a name which Python keeps for
    itself, such as `import`, one at its end.
    """

    def __init__(
        self, *, package: str, groups: Mapping[str, Mapping[str, str]], **settings: Any
    ) -> None:
        super().__init__(**settings)
        self.package = package
        self.groups = groups
        self.summaries = {name: line for group in groups.values() for name, line in group.items()}

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002  (click's signature)
        """Return the names in the order in which a newcomer needs them."""
        return list(self.summaries)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002  (click's signature)
        """Import and return one command; None if there is none of that name."""
        if cmd_name not in self.summaries:
            return None
        module = cmd_name.replace("-", "_") + ("_" if iskeyword(cmd_name) else "")
        command = import_module(f"{self.package}.{module}").command
        assert isinstance(command, click.Command)  # noqa: S101  (narrows what import_module gives)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that is meant; an unknown one is a UsageError with a suggestion."""
        if args[0] in self.summaries:
            return super().resolve_command(ctx, args)
        near = difflib.get_close_matches(args[0], self.summaries, n=1, cutoff=0.5)
        hint = f" Did you mean '{near[0]}'?" if near else ""
        raise click.UsageError(f"No such command '{args[0]}'.{hint}", ctx)

    def shell_complete(
        self, ctx: click.Context, incomplete: str
    ) -> list[click.shell_completion.CompletionItem]:
        """Return the commands and options that begin so, without importing any command."""
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
    """Return a group of commands that shows its help where none of them is named."""

    @click.group(
        name=name,
        cls=LazyGroup,
        invoke_without_command=True,
        package=package,
        groups={"Commands": summaries},
        help=text,
    )
    @click.pass_context
    def group(context: click.Context) -> None:
        if context.invoked_subcommand is None:
            result(context.get_help())

    assert isinstance(group, LazyGroup)  # noqa: S101  (narrows what click gives)
    return group
