"""Options that several commands share, with one help text and one default."""

from __future__ import annotations

from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import UsageError
from rigrunner.api.partner_keys import KEYS
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
    "--station", shell_complete=stations, help="Include the plugins of this station's folder."
)
set_option = click.option(
    "--set", "assigned", multiple=True, metavar="NAME=VALUE", help="Give an input; may be repeated."
)
answers_option = click.option(
    "--answers",
    "answers_file",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Take inputs from a YAML file; --set takes precedence.",
)
record_option = click.option(
    "--record",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Save all communication with the instruments on a tape in this new folder.",
)
replay_option = click.option(
    "--replay",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Replay a tape; no instrument is used.",
)
debugger_option = click.option(
    "--debugger",
    is_flag=True,
    help="Wait for device calls without a time limit, for debugging.",
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
raw_option = click.option(
    "--raw",
    is_flag=True,
    help="CSV: keep texts that a spreadsheet would take for formulas.",
)


def override_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that start a run despite a calibration that is overdue or missing."""
    override = click.option(
        "--override",
        "overridden",
        multiple=True,
        metavar="INSTRUMENT",
        help="Start with this instrument's calibration overdue, missing or out of range.",
    )
    by = click.option(
        "--by", default="", metavar="NAME", help="Who is responsible for the override."
    )
    reason = click.option("--reason", default="", metavar="TEXT", help="Why it is overridden.")
    return override(by(reason(command)))


def partner_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that name partner runs; the command gets them by name, as `partners`."""

    @wraps(command)
    def with_partners(
        *arguments: Any,
        partner: tuple[str, ...],
        **options: Any,
    ) -> Any:
        by_option = {name: options.pop(name) for name in KEYS}
        pairs = [*partner, *(f"{name}={run}" for name, run in by_option.items() if run)]
        return command(*arguments, partners=_partner_runs(pairs), **options)

    partner = click.option(
        "--partner",
        multiple=True,
        metavar="NAME=RUN",
        help="Take this run as the partner run of that name; may be repeated.",
    )
    before, after = (
        click.option(
            f"--{name.replace('_', '-')}",
            metavar="RUN",
            shell_complete=stored_runs,
            help=f"The same as --partner {name}=RUN.",
        )
        for name in KEYS
    )
    return partner(before(after(with_partners)))


def _partner_runs(pairs: Iterable[str]) -> dict[str, str]:
    partners: dict[str, str] = {}
    for text in pairs:
        name, equals, run = text.partition("=")
        if not (name and equals and run):
            raise UsageError(f"'--partner {text}' names no run", hint="write '--partner dark=RUN'")
        if name in partners:
            raise UsageError(f"the partner run '{name}' is named twice", hint="leave one out")
        partners[name] = run
    return partners


def named_values(assignments: Iterable[str]) -> dict[str, str]:
    """Return the values of `--set NAME=VALUE`; raise UsageError for any other form."""
    values: dict[str, str] = {}
    for text in assignments:
        name, equals, value = text.partition("=")
        if not (name and equals and value.strip()):
            raise UsageError(
                f"'--set {text}' gives no input", hint="write it as '--set specimen=SN-17'"
            )
        if name in values:
            raise UsageError(f"the input '{name}' is given twice", hint="leave one of the two out")
        values[name] = value
    return values
