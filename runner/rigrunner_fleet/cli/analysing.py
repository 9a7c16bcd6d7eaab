"""Shared by commands that analyse stored runs with changed settings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner_fleet.reanalysis.changes import Changes

paths_argument = click.argument(
    "paths", nargs=-1, required=True, metavar="PATH...", type=click.Path(path_type=Path)
)
_analysis_option = click.option(
    "--analysis",
    "file",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="A YAML file that replaces parts of the procedures' analysis.",
)
_primary_option = click.option(
    "--primary", default="", metavar="METHOD", help="Another primary compensation."
)


def changes_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of changes."""
    return _analysis_option(_primary_option(command))


def changes_in(file: Path | None, primary: str, station: str | None) -> Changes:
    """Return the changes of the options --analysis and --primary; raise InvalidFileError."""
    from rigrunner.procedure import AnalysisFile  # noqa: PLC0415  (not for help)
    from rigrunner.run.lab_plugins import lab_registry  # noqa: PLC0415  (the same)
    from rigrunner.yamlfile import read, validate  # noqa: PLC0415  (the same)
    from rigrunner_fleet.reanalysis.changes import (  # noqa: PLC0415  (the same)
        Changes,
        check_settings,
    )

    if file is None:
        return Changes(primary=primary)
    document = read(file)
    analysis_file = validate(AnalysisFile, document)
    if analysis_file.analysis:
        check_settings(document, lab_registry(station))
    return Changes(analysis_file.analysis, primary, analysis_file.named)
