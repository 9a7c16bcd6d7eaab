"""`rigrunner completion`: a script with which a shell completes commands, procedures and runs."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

from rigrunner.cli.completing import PROGRAM, VARIABLE
from rigrunner.cli.output import result


@click.command(name="completion")
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def command(context: click.Context, shell: str) -> None:
    """Print a script for shell completion.

    For bash put 'eval "$(rigrunner completion bash)"' into ~/.bashrc, for zsh the same with zsh
    into ~/.zshrc; for fish write the script to ~/.config/fish/completions/rigrunner.fish.
    """
    kind = get_completion_class(shell)
    assert kind is not None  # noqa: S101  (click has these three)
    result(kind(context.find_root().command, {}, PROGRAM, VARIABLE).source())
