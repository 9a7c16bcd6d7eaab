"""What a shell completes: the words that may stand at the cursor."""

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
"""By this variable of the environment the shell asks for words, as click has it."""
_PATH = "file"
"""The type of item by which click leaves it to the shell to complete a path."""


def complete(command: click.Command, instruction: str) -> int:
    """Print the words for the shell that asks, and return 0; 1 if nothing can be said.

    Nothing else is printed, whatever happens: the shell would show it in the middle of a line.
    """
    try:
        return shell_complete(command, {}, PROGRAM, VARIABLE, instruction)
    except Exception:  # noqa: BLE001  (see above)
        return 1


def procedures(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the shipped procedures and the files here that begin so."""
    return _names_or_files(procedure_names(), incomplete)


def stations(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the shipped stations and the files here that begin so."""
    return _names_or_files(station_names(), incomplete)


def stored_runs(
    context: click.Context, _: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Return the runs in the folder of runs that begin so, the newest first."""
    runs = Path(context.params.get("runs") or "runs")
    names = [name for name in reversed(run_names(runs)) if name.startswith(incomplete)]
    return [CompletionItem(name) for name in names] or [CompletionItem(incomplete, type=_PATH)]


def plugin_names(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the installed plugins that begin so."""
    return list(_plugins(incomplete))


def decision_rules(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the installed decision rules that begin so."""
    return list(_plugins(incomplete, "decision_rule"))


def _plugins(incomplete: str, kind: str = "") -> Iterator[CompletionItem]:
    from rigrunner.registry import load_registry  # noqa: PLC0415  (pydantic; only here)

    for plugin in load_registry().plugins:
        record = plugin.record
        if record.name.startswith(incomplete) and kind in {"", plugin.kind}:
            yield CompletionItem(record.name, help=record.help)


def _names_or_files(names: Iterable[str], incomplete: str) -> list[CompletionItem]:
    here = sorted(path.name for ending in ("yaml", "yml") for path in Path().glob(f"*.{ending}"))
    found = [name for name in (*names, *here) if name.startswith(incomplete)]
    return [CompletionItem(name) for name in found] or [CompletionItem(incomplete, type=_PATH)]
