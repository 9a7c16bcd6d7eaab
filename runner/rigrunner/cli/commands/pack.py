"""`rigrunner pack`: pack a sealed run into one file."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.api.errors import UsageError
from rigrunner.cli.options import run_argument, runs_option
from rigrunner.cli.output import result
from rigrunner.run.locate import find_run


@click.command(name="pack")
@run_argument
@runs_option
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="The new file; by default the run's name with .zip.",
)
def command(run: str, runs: Path, out: Path | None) -> None:
    """Pack a sealed run into one file, with the digest of every part.

    The run stays as it is. The same run always gives the same file.
    """
    from rigrunner.documents.packing.pack import pack

    folder = find_run(run, runs)
    if not folder.is_dir():
        raise UsageError(
            f"{folder} is not a run folder", hint="the folder is packed with all its files"
        )
    target = out or Path(f"{folder.resolve().name}.zip")
    contents = pack(folder, target)
    count, size = len(contents.files), sum(file.bytes for file in contents.files)
    result(f"{target}: {count} files, {size / 1e6:.1f} MB, run {contents.run}")
