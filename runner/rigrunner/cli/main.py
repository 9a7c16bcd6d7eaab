"""The command `rigrunner`: its commands by name, each imported when it is called."""

from __future__ import annotations

import atexit
import gc
import os
import sys
from typing import TYPE_CHECKING

import click

from rigrunner import __version__
from rigrunner.blas import ONE_THREAD
from rigrunner.cli.boundary import run_command
from rigrunner.cli.completing import VARIABLE, complete
from rigrunner.cli.lazy import LazyGroup
from rigrunner.cli.output import result
from rigrunner.cli.package_commands import Commands, package_commands

if TYPE_CHECKING:
    from collections.abc import Sequence


ENVIRONMENT = {**ONE_THREAD, "PYDANTIC_DISABLE_PLUGINS": "__all__"}
"""Defaults of environment variables. Finding plugins of pydantic, of which none are needed here,
takes the time of several models, and such plugins would change how files are checked."""

GC_THRESHOLD = 50_000
"""Number of new objects after which garbage is collected: some 10 MB. Python's default is 700."""

COMMANDS = {
    "Run": {
        "run": "Run a procedure on a station.",
        "resume": "Resume an interrupted run.",
        "recover": "Close an interrupted run as it is, or salvage a damaged one.",
        "queue": "Queue specimens and run them one after the other.",
    },
    "Prepare": {
        "check": "Check a procedure, and how it fits a station, without a rig.",
        "plan": "Preview steps, expected values, duration and disk space.",
        "approve": "Approve a procedure in its present form, or show its approvals.",
        "upgrade": "Upgrade files of an older version of the language.",
        "init": "Create a lab folder with a station, procedures and a plugin.",
        "devices": "Connect each device of a station, and report its identity and state.",
        "jog": "Set and read one device manually, within the limits of its station.",
        "doctor": "Check the installation and the machine, and suggest fixes.",
    },
    "Results": {
        "runs": "List the stored runs.",
        "show": "Show the recordings, events and results of a stored run.",
        "analyse": "Analyse a stored run again.",
        "report": "Write the report of a stored run again.",
        "compare": "List the differences between two procedures or two runs.",
        "import": "Import recordings made by another program.",
        "fit": "Fit a curve to columns of a CSV file.",
        "register": "Create entries for the register of instruments.",
        "pack": "Pack a sealed run into one file, with the digest of every part.",
        "unpack": "Unpack a packed run into the folder of runs.",
    },
    "Certificates": {
        "certify": "Issue a certificate for a stored run.",
        "amend": "Issue a document that replaces a certificate.",
        "withdraw": "Withdraw a certificate without replacing it.",
        "verify": "Verify a certificate or a run, and recompute its numbers from the samples.",
        "sign": "Sign a certificate with the laboratory's key, or create a key.",
        "decide": "Decide a stored run again, by another rule or other limits.",
    },
    "Fleet": {},
    "Develop": {
        "new": "Create a plugin that works at once.",
        "plugins": "List the plugins and their settings.",
        "schema": "Print the JSON Schema of procedures, stations and other files.",
        "completion": "Print a script for shell completion.",
    },
}
"""The core's commands with their help lines, in groups."""


@click.group(
    cls=LazyGroup,
    invoke_without_command=True,
    own=Commands("rigrunner.cli.commands", COMMANDS),
    others=package_commands,
    renamed={"diff": "compare"},
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="'rigrunner demo' needs no rig, and takes less than a minute.",
)
@click.version_option(__version__, prog_name="rigrunner", message="%(prog)s %(version)s")
@click.pass_context
def rigrunner(context: click.Context) -> None:
    """Run laboratory test procedures; report each result with its measurement uncertainty."""
    if context.invoked_subcommand is None:
        result(context.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code (`rigrunner.api.errors.ExitCode`).

    A shell that asks for completion gets the words. Linear algebra has one thread, unless the
    environment says otherwise.
    """
    open_standard_streams()
    for name, value in ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    raise_gc_threshold()
    instruction = os.environ.get(VARIABLE)
    if instruction:
        return complete(rigrunner, instruction)
    return run_command(rigrunner, arguments)


def raise_gc_threshold() -> None:
    """Collect garbage seldom, and not at the end of the process.

    A command creates thousands of classes, and keeps them and most other objects until it ends.
    Searching them again and again, and once more at the end, is a quarter of the time of `plan`.
    """
    gc.set_threshold(GC_THRESHOLD, *gc.get_threshold()[1:])
    atexit.register(gc.freeze)


def open_standard_streams() -> None:
    """Connect closed standard streams to the null device.

    Otherwise the next opened file would get the stream's number, and messages would be written into
    it, for example into a journal.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
        if getattr(sys, name) is None:
            mode = "w" if number else "r"
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: PTH123, SIM115  (a stream for as long as the program lasts)
