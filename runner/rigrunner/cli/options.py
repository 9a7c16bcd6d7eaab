"""Options that several commands share, with one help text and one default."""

from __future__ import annotations

from pathlib import Path

import click

runs_option = click.option(
    "--runs",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("runs"),
    show_default=True,
    help="The folder that holds the runs.",
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
