"""Complete the words at the cursor of a shell."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from click.shell_completion import CompletionItem, shell_complete

from rigrunner.run.locate import procedure_names, run_names, station_names

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    import click

PROGRAM = "rigrunner"
VARIABLE = "_RIGRUNNER_COMPLETE"
"""The environment variable by which the shell asks for words, as in click."""
_PATH = "file"
"""The type of item by which click lets the shell complete a path."""


def complete(command: click.Command, instruction: str) -> int:
    """Print the words for the shell, and return 0, or 1 if there are none.

    Nothing else is ever printed: the shell would show it within the line.
    """
    try:
        return shell_complete(command, {}, PROGRAM, VARIABLE, instruction)
    except Exception:  # noqa: BLE001  (see above)
        return 1


def procedures(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the matching shipped procedures and files."""
    return _names_or_files(procedure_names(), incomplete)


def stations(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the matching shipped stations and files."""
    return _names_or_files(station_names(), incomplete)


def stored_runs(
    context: click.Context, _: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Return the matching runs in the folder of runs, the newest first."""
    runs = Path(context.params.get("runs") or "runs")
    names = [name for name in reversed(run_names(runs)) if name.startswith(incomplete)]
    return [CompletionItem(name) for name in names] or [CompletionItem(incomplete, type=_PATH)]


def plugin_names(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the matching installed plugins."""
    return list(_plugins(incomplete))


def decision_rules(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the matching installed decision rules."""
    return list(_plugins(incomplete, "decision_rule"))


def _plugins(incomplete: str, kind: str = "") -> Iterator[CompletionItem]:
    from rigrunner.registry import load_registry  # noqa: PLC0415  (pydantic; only here)

    for plugin in load_registry().plugins:
        record = plugin.record
        if record.name.startswith(incomplete) and kind in {"", plugin.kind}:
            yield CompletionItem(record.name, help=record.help)


def _names_or_files(names: Iterable[str], incomplete: str) -> list[CompletionItem]:
    files = sorted(path.name for ending in ("yaml", "yml") for path in Path().glob(f"*.{ending}"))
    matches = [name for name in (*names, *files) if name.startswith(incomplete)]
    return [CompletionItem(name) for name in matches] or [CompletionItem(incomplete, type=_PATH)]
