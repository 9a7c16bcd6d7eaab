"""`rigrunner init`: create a lab folder that runs at once."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from rigrunner.cli.output import message, result


@click.command(name="init")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path, file_okay=False))
@click.option("--lab", default="", help="With which lab to begin, where packages bring several.")
def command(folder: Path, lab: str) -> None:
    """Create a lab folder with a station, procedures and a plugin.

    It runs at once on simulated devices. No file is overwritten.
    """
    from rigrunner.registry import load_registry
    from rigrunner.tools.labfolder import STATION, make_lab

    procedures = make_lab(folder, load_registry(), lab)
    message(f"Made the lab folder {folder}; its README.md says what is where. To try it:")
    if folder.resolve() != Path.cwd():
        result(f"cd {shlex.quote(str(folder))}")
    for procedure in procedures:
        result(f"rigrunner run {procedure} --station {STATION} --unattended")
