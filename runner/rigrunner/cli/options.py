"""Options that several commands share, with one help text and one default."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import UsageError
from rigrunner.cli.completing import procedures, stations, stored_runs

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

runs_option = click.option(
    "--runs",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("runs"),
    show_default=True,
    help="The folder that holds the runs.",
)
procedure_argument = click.argument("procedure", shell_complete=procedures)
run_argument = click.argument("run", shell_complete=stored_runs)
station_option = click.option(
    "--station",
    required=True,
    shell_complete=stations,
    help="A station file, or the name of a shipped one.",
)
lab_option = click.option(
    "--station", shell_complete=stations, help="Take in the plugins of this station's own folder."
)
set_option = click.option(
    "--set", "given", multiple=True, metavar="NAME=VALUE", help="Give an input; may be repeated."
)
answers_option = click.option(
    "--answers",
    "answers_file",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Take inputs from a YAML file; --set goes first.",
)
record_option = click.option(
    "--record",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Save every exchange with every instrument, on a tape in this new folder.",
)
replay_option = click.option(
    "--replay",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Play a tape back: no instrument is asked.",
)


def override_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options by which a run starts although a calibration stands against it."""
    wanted = click.option(
        "--override",
        "overridden",
        multiple=True,
        metavar="INSTRUMENT",
        help="Start although this instrument's calibration is overdue, missing or out of range.",
    )
    by = click.option("--by", default="", metavar="NAME", help="Who answers for the override.")
    reason = click.option("--reason", default="", metavar="TEXT", help="Why it is overridden.")
    return wanted(by(reason(command)))


debugger_option = click.option(
    "--debugger",
    is_flag=True,
    help="Give no call of a device up, however long it takes: for a debugging session.",
)


json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
raw_option = click.option(
    "--raw",
    is_flag=True,
    help="CSV: texts as they are, also where a spreadsheet takes them for formulas.",
)


def named_values(given: Iterable[str]) -> dict[str, str]:
    """Return what `--set NAME=VALUE` gave; raise UsageError for what is no such pair."""
    values: dict[str, str] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not (name and equals and value.strip()):
            raise UsageError(
                f"'--set {text}' gives no input", hint="write it as '--set specimen=SN-17'"
            )
        if name in values:
            raise UsageError(f"the input '{name}' is given twice", hint="leave one of the two out")
        values[name] = value
    return values
