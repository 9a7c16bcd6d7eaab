#!/usr/bin/env python3
"""Writes what each command says of itself, from the commands.

python docs/reference/help_page.py docs/reference
"""

from __future__ import annotations

import re
import sys
from inspect import cleandoc
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.cli.main import rigrunner

if TYPE_CHECKING:
    from collections.abc import Iterator

HEAD = """# Commands

What `--help` prints, for each command. Made by `docs/reference/help_page.py`.

Results go to stdout; progress and messages go to stderr. `NO_COLOR` is respected.
[Exit codes](exit-codes.md) tell how a command ended. A PROCEDURE or STATION is a file or a shipped
name. A RUN is a run folder, its `run.h5`, or the beginning of its name.
"""


def commands(group: click.Group, words: str) -> Iterator[tuple[str, click.Command]]:
    """Yield each command with the words that call it, those of groups too."""
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if command is None:
            continue
        yield f"{words} {name}", command
        if isinstance(command, click.Group):
            yield from commands(command, f"{words} {name}")


def section(words: str, command: click.Command) -> str:
    """Return what one command says."""
    arguments = [_argument(each) for each in command.params if isinstance(each, click.Argument)]
    options = [each for each in command.params if isinstance(each, click.Option)]
    parts = [f"## `{' '.join([words, *arguments])}`", _text(cleandoc(command.help or ""))]
    rows = [f"| {_spelt(each)} | {_description(each)} |" for each in options if not each.hidden]
    if rows:
        parts.append("\n".join(["| option | meaning |", "|---|---|", *rows]))
    return "\n\n".join(parts) + "\n"


def page() -> str:
    """Return the whole page."""
    return "\n".join([HEAD, *(section(*each) for each in commands(rigrunner, "rigrunner"))])


def _argument(argument: click.Argument) -> str:
    name = (argument.metavar or (argument.name or "").upper()).strip("[].")
    name += "..." if argument.nargs < 0 else ""
    return name if argument.required else f"[{name}]"


def _spelt(option: click.Option) -> str:
    value = "" if option.is_flag or option.count else f" {_value(option)}"
    return ", ".join(f"`{name}{value}`" for name in (*option.opts, *option.secondary_opts))


def _value(option: click.Option) -> str:
    if isinstance(option.type, click.Choice):
        return "\\|".join(str(each) for each in option.type.choices)
    return option.metavar or option.type.name.upper()


def _description(option: click.Option) -> str:
    sentences = [_text(option.help or "").replace("|", "\\|")]
    sentences += ["Needed."] if option.required else []
    sentences += ["May be repeated."] if option.multiple and "repeated" not in sentences[0] else []
    return " ".join(" ".join(sentences).split())


def _text(text: str) -> str:
    """Return a help text as Markdown, with options as code: '--' would become a dash."""
    escaped = text.replace("\b\n", "").replace("<", "&lt;").replace("*", "\\*")
    return re.sub(r"(?<![\w`-])(--[a-z][\w-]*)", r"`\1`", escaped)


def main(folder: Path) -> None:
    """Write the page."""
    (folder / "help.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
