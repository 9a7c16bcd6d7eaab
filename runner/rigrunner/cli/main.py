"""The command `rigrunner`: its commands by name, none imported before it is called."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import click

from rigrunner import __version__
from rigrunner.blas import ONE_THREAD
from rigrunner.cli.boundary import run_command
from rigrunner.cli.completing import VARIABLE, complete
from rigrunner.cli.lazy import LazyGroup
from rigrunner.cli.output import result
from rigrunner.cli.standard import open_standard_streams

if TYPE_CHECKING:
    from collections.abc import Sequence

ENVIRONMENT = {**ONE_THREAD, "PYDANTIC_DISABLE_PLUGINS": "__all__"}
"""What the environment does not say itself. Looking for plugins of pydantic's, which nothing here
needs, takes the time of several models, and what they find would change how files are checked."""

SUMMARIES = {
    "demo": "Run both procedures on the simulated rig and write the report.",
    "run": "Run a procedure on a station.",
    "import": "Import recordings that another program made.",
    "panel": "Open the operator's screen in a browser.",
    "resume": "Go on with a run that was broken off.",
    "recover": "Close an interrupted run as it is, or salvage a damaged one.",
    "approve": "Approve a procedure as it stands, or show who did.",
    "check": "Check a procedure, and how it fits a station, without a rig.",
    "plan": "Show each action of a run, its torque, time and disk.",
    "analyse": "Analyse a stored run again.",
    "reanalyse": "Analyse many stored runs again, on all cores or a cluster.",
    "golden": "Hold what stored runs give against references, before new software is trusted.",
    "decide": "Decide a stored run again, by another rule or other limits.",
    "report": "Write the report of a stored run again.",
    "certify": "Issue a certificate on a stored run.",
    "amend": "Issue a document that replaces a certificate.",
    "verify": "Check a certificate or a run, and that its numbers follow from the samples.",
    "sign": "Sign a certificate with the laboratory's own key, or make a key.",
    "runs": "List the stored runs.",
    "archive": "Index many run folders, search and export what they found.",
    "trend": "Make control charts of what many runs found.",
    "capability": "Compare what many runs found with limits.",
    "fit": "Fit a curve to columns of a CSV file.",
    "gauge-rr": "Study how well a gauge repeats, and reproduces between operators.",
    "pack": "Write a sealed run to one file, with the digest of everything in it.",
    "unpack": "Take a run that was packed into the folder of runs.",
    "show": "Show what a stored run holds and found.",
    "diff": "Tell in words what changed between two procedures or two runs.",
    "plugins": "List the plugins and what each can be told.",
    "new": "Make a plugin of your own, which works at once.",
    "check-plugin": "Check that a plugin keeps to what every plugin must.",
    "devices": "Connect each device of a station, and say what it is and whether it is safe.",
    "jog": "Set and read one device by hand, within the limits of its station.",
    "init": "Make a lab folder with station, procedures and a plugin.",
    "schema": "Print the JSON Schema of procedures, stations and our other kinds of files.",
    "doctor": "Look at the installation and the machine, and say how to mend what is not right.",
    "completion": "Print a script that lets a shell complete.",
    "study": "Measure what checks and uncertainties are worth, on random simulated rigs.",
}


@click.group(
    cls=LazyGroup,
    invoke_without_command=True,
    package="rigrunner.cli.commands",
    summaries=SUMMARIES,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="'rigrunner demo' needs no rig, and takes less than a minute.",
)
@click.version_option(__version__, prog_name="rigrunner", message="%(prog)s %(version)s")
@click.pass_context
def rigrunner(context: click.Context) -> None:
    """Run laboratory test procedures, and say what they measured and how surely."""
    if context.invoked_subcommand is None:
        result(context.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code (`rigrunner.api.errors.ExitCode`).

    A shell that asks what may stand at its cursor gets an answer instead. Linear algebra gets one
    thread, unless the environment gives it more.
    """
    open_standard_streams()
    for name, value in ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    instruction = os.environ.get(VARIABLE)
    if instruction:
        return complete(rigrunner, instruction)
    return run_command(rigrunner, arguments)
