"""`rigrunner unpack`: unpack a run from one file."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.cli.options import runs_option
from rigrunner.cli.output import result


@click.command(name="unpack")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@runs_option
def command(file: Path, runs: Path) -> None:
    """Unpack a packed run into the folder of runs.

    A file that does not match its digests, or a run that exists already, is refused.
    """
    from rigrunner.documents.packing.unpack import unpack

    result(str(unpack(file, runs)))
