"""`rigrunner init`: create a lab folder that runs at once."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from rigrunner.cli.output import message, result


@click.command(name="init")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path, file_okay=False))
@click.option("--lab", default="", help="The lab template, if packages provide several.")
def command(folder: Path, lab: str) -> None:
    """Create a lab folder with a station, procedures and a plugin.

    It works at once, with simulated devices. No file is overwritten.
    """
    from rigrunner.registry import load_registry
    from rigrunner.tools.labfolder import STATION, make_lab

    procedures = make_lab(folder, load_registry(), lab)
    message(f"Created the lab folder {folder}; its README.md describes the files. To try it:")
    if folder.resolve() != Path.cwd():
        result(f"cd {shlex.quote(str(folder))}")
    for procedure in procedures:
        result(f"rigrunner run {procedure} --station {STATION} --unattended")
