"""Shared by the commands of the archive: its location, filters, and the report of indexing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import UsageError
from rigrunner.api.events import Outcome
from rigrunner.api.verdict import Verdict
from rigrunner.cli.options import runs_option
from rigrunner.cli.output import message

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from rigrunner_fleet.archive import Indexed
    from rigrunner_fleet.archive.filters import Filters

_EXAMPLES = {
    "--input": "--input order=A-17",
    "--figure": "--figure 'natural frequency=380..420 Hz'",
    "--where": "--where 'temperature=100 °C'",
}
_SHOWN = 20
"""Paths that are listed; the rest is counted."""

database_option = click.option(
    "--database",
    default="",
    metavar="DATABASE",
    envvar="RIGRUNNER_DATABASE",
    help="The archive: a file, or postgresql://...; by default in the folder of the runs.",
)
folders_argument = click.argument(
    "folders", nargs=-1, type=click.Path(path_type=Path, file_okay=False), metavar="[FOLDER]..."
)
jobs_option = click.option(
    "--jobs",
    type=click.IntRange(min=1),
    help="Processes to read with; by default one per core.",
)
_TEXTS: Mapping[str, str] = {
    "specimen": "The specimen; * matches any characters, ? one.",
    "type": "The specimen's type, if the procedure asks for it.",
    "lot": "The specimen's lot, if the procedure asks for it.",
    "rig": "The station.",
    "procedure": "The procedure's id.",
    "revision": "The procedure's revision.",
    "operator": "Who did the run.",
    "verdict": f"The verdict in force: {', '.join(Verdict)} or none.",
    "outcome": f"How the run ended: {', '.join(Outcome)}.",
}
_RANGES: Mapping[str, str] = {
    "torque": "The torque, as '0.5..0.8 N·m'; with --frequency or --load, that of a set-point.",
    "uncertainty": "Its expanded uncertainty.",
    "raw_peak": "The raw peak.",
    "frequency": "A set-point, such as '10 Hz' or '5..15 Hz'.",
    "load": "The load at a set-point, such as '990..1010 N'.",
}


def filter_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that select runs."""
    options = [
        *(_option(name, "TEXT", line, multiple=True) for name, line in _TEXTS.items()),
        *(_option(name, "RANGE", line) for name, line in _RANGES.items()),
        click.option("--since", metavar="DATE", help="Begun on that day or later (UTC)."),
        click.option("--until", metavar="DATE", help="Begun on that day or before (UTC)."),
        click.option(
            "--input", "inputs", multiple=True, metavar="NAME=TEXT", help="An input of the run."
        ),
        click.option(
            "--figure",
            "figures",
            multiple=True,
            metavar="NAME=RANGE",
            help="A figure of the rig, such as 'inertia=0.002..0.003 kg·m²'.",
        ),
        click.option(
            "--result",
            "named",
            multiple=True,
            metavar="NAME[=RANGE]",
            help="A named result, such as 'resistance=138..139 Ω'.",
        ),
        click.option(
            "--where",
            multiple=True,
            metavar="NAME=VALUE",
            help="The coordinates of a result, such as 'temperature=100 °C'.",
        ),
        click.option("--real", is_flag=True, help="Leave out simulated and replayed runs."),
        click.option("--copies", is_flag=True, help="Count each copy of a run."),
        click.option(
            "--limit", type=click.IntRange(min=1), metavar="N", help="The newest N runs only."
        ),
    ]
    for option in reversed([runs_option, database_option, *options]):
        command = option(command)
    return command


def _option(name: str, metavar: str, line: str, *, multiple: bool = False) -> Callable[..., Any]:
    flag = f"--{name.replace('_', '-')}"
    return click.option(flag, name, multiple=multiple, metavar=metavar, help=line)


def filters_in(options: Mapping[str, Any]) -> Filters:
    """Return the filters of the options; raise UsageError."""
    from rigrunner_fleet.archive.filters import filters_of  # noqa: PLC0415  (help needs no database)

    inputs = _pairs("--input", options["inputs"])
    figures = _single("--figure", options["figures"])
    where = _single("--where", options["where"])
    named = [argument.partition("=") for argument in options["named"]]
    result = {name: value_range if equals else None for name, equals, value_range in named}
    if len(result) < len(named):
        raise UsageError("'--result' names a result twice")
    filters = {name: value for name, value in options.items() if name != "named"}
    return filters_of(
        **{**filters, "inputs": inputs, "figures": figures, "where": where, "result": result}
    )


def _single(option: str, arguments: Iterable[str]) -> dict[str, str]:
    values = _pairs(option, arguments)
    twice = next((name for name, texts in values.items() if len(texts) > 1), "")
    if twice:
        raise UsageError(f"'{option} {twice}' is given twice")
    return {name: texts[0] for name, texts in values.items()}


def _pairs(option: str, arguments: Iterable[str]) -> dict[str, list[str]]:
    values: dict[str, list[str]] = {}
    for argument in arguments:
        name, equals, value = argument.partition("=")
        if not (name and equals and value):
            hint = f"such as {_EXAMPLES[option]}"
            raise UsageError(f"'{option} {argument}' names nothing to look for", hint=hint)
        values.setdefault(name, []).append(value)
    return values


def report_indexed(indexed: Sequence[Indexed]) -> None:
    """Report for each folder its runs, those that cannot be read, and those that are gone."""
    for folder in indexed:
        runs = "1 run" if folder.runs == 1 else f"{folder.runs} runs"
        message(f"{folder.folder}: {runs}, {folder.new} new, {folder.changed} updated.")
        _report_list("Unreadable", (f"{path}: {problem}" for path, problem in folder.unreadable))
        _report_list("Gone since they were indexed", folder.missing)


def _report_list(title: str, lines: Iterable[str]) -> None:
    shown = list(lines)
    if shown:
        message(f"{title}: {len(shown)}")
        message("\n".join(f"  {line}" for line in shown[:_SHOWN]))
        if len(shown) > _SHOWN:
            message(f"  and {len(shown) - _SHOWN} more")
