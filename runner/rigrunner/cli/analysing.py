"""What commands share that analyse stored runs in another way than their procedures say."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rigrunner.workflow.reanalysis.changes import Changes

paths_argument = click.argument(
    "paths", nargs=-1, required=True, metavar="PATH...", type=click.Path(path_type=Path)
)
primary_option = click.option(
    "--primary", default="", metavar="METHOD", help="Another primary compensation."
)


def changes_in(file: Path | None, primary: str) -> Changes:
    """Return what the options --analysis and --primary change; raise InvalidFileError."""
    from rigrunner.procedure import AnalysisFile  # noqa: PLC0415  (not for help)
    from rigrunner.workflow.reanalysis.changes import Changes  # noqa: PLC0415  (the same)
    from rigrunner.yamlfile import read, validate  # noqa: PLC0415  (the same)

    given = None if file is None else validate(AnalysisFile, read(file)).analysis
    return Changes(given, primary)
