"""`rigrunner verify`: check that a run file, or a certificate, is genuine."""

from __future__ import annotations

from dataclasses import asdict
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.api.errors import ExitCode, UsageError
from rigrunner.cli.completing import stored_runs
from rigrunner.cli.options import json_option, lab_option, runs_option
from rigrunner.cli.output import result, result_json
from rigrunner.run.locate import find_run

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

FORMS = (".json", ".html", ".pdf")
RUN_FILES = (".h5", ".hdf5")
MOST_SHOWN = 12
"""The number of printed differences of one check."""


@click.command(name="verify")
@click.argument("what", metavar="CERTIFICATE|RUN", shell_complete=stored_runs)
@click.argument("run", required=False, shell_complete=stored_runs)
@runs_option
@lab_option
@click.option(
    "--trust",
    "trusted",
    multiple=True,
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    envvar="RIGRUNNER_TRUSTED_KEYS",
    help="Public keys to trust; a document that none of them signed does not match.",
)
@click.option(
    "--letterhead",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The laboratory's folder: its record of numbers, logo, texts and templates.",
)
@json_option
def command(
    *,
    what: str,
    run: str | None,
    runs: Path,
    station: str | None,
    trusted: tuple[Path, ...],
    letterhead: Path | None,
    as_json: bool,
) -> ExitCode:
    """Verify a certificate or a run, and recompute its numbers from the samples.

    The first line is the verdict, the others list what was checked. The exit code is 1 if anything
    differs, 14 if the document was withdrawn, 11 if replaced, 12 if a page is not proven, 13 if its
    numbers are from another revision of a method, 10 if the run is missing.
    """
    from rigrunner.documents.verifying.certificate import Means, verify_certificate
    from rigrunner.documents.verifying.run import verify_run
    from rigrunner.run.lab_plugins import lab_registry

    registry, path = lab_registry(station), Path(what)
    if path.suffix in FORMS:
        run_path = None if run is None else find_run(run, runs)
        means = Means(
            run=run_path, runs=runs, registry=registry, trusted=trusted, letterhead=letterhead
        )
        verification = verify_certificate(path, means)
    elif run is not None:
        raise UsageError(
            f"'{what}' is not a certificate",
            hint=f"the certificate comes first: a file {', '.join(FORMS)}",
        )
    elif path.is_file() and path.suffix not in RUN_FILES:
        raise UsageError(
            f"{path} is neither a certificate nor a run",
            hint=f"a certificate is a file {', '.join(FORMS)}; a run is its folder or its run.h5",
        )
    else:
        verification = verify_run(find_run(what, runs), registry)
    if as_json:
        facts = {"verdict": verification.conclusion, "match": verification.matches}
        result_json({**facts, **asdict(verification)})
        return verification.exit_code
    groups = {
        "OK       ": verification.held,
        "DIFFERS  ": list(_first_of_each(verification.differences)),
        "WITHDRAWN ": verification.withdrawn,
        "REPLACED ": verification.replaced,
        "UNPROVEN ": verification.unproven,
        "OTHER    ": [f"numbers not recomputed: {text}" for text in verification.not_recomputed],
        "OPEN     ": verification.unchecked,
        "info     ": verification.information,
    }
    lines = [f"{mark}{text}" for mark, group in groups.items() for text in group]
    result("\n".join([verification.conclusion, "", *lines]))
    return verification.exit_code


def _first_of_each(differences: Sequence[str]) -> Iterator[str]:
    """Yield the first differences of each check, and the number of the others."""
    for what, group in groupby(differences, key=lambda text: text.partition(": ")[0]):
        texts = list(group)
        yield from texts[:MOST_SHOWN]
        if len(texts) > MOST_SHOWN:
            yield f"{what}: and {len(texts) - MOST_SHOWN} more (--json lists all)"
