"""`rigrunner analyse`: analyse a stored run again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.api.errors import UsageError
from rigrunner.cli.options import json_option, lab_option, partner_option, run_argument, runs_option
from rigrunner.cli.output import message, result, result_json
from rigrunner.cli.summary import identity, summary
from rigrunner.run.locate import find_run

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.errors import ExitCode


@click.command(name="analyse")
@run_argument
@runs_option
@lab_option
@partner_option
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Write the result to this new file, as JSON.",
)
@json_option
def command(
    run: str,
    runs: Path,
    station: str | None,
    *,
    partners: Mapping[str, str],
    out: Path | None,
    as_json: bool,
) -> ExitCode:
    """Analyse a stored run again.

    The run file does not change.
    """
    from rigrunner.analysis.document import document
    from rigrunner.cli.progress import shown_progress
    from rigrunner.run.lab_plugins import lab_registry
    from rigrunner.run.stored import analyse_run, verdict_code
    from rigrunner.runfile.durable import write_whole

    if out is not None and out.exists():
        raise UsageError(f"{out} exists", hint="results are never overwritten; name another file")
    partner_paths = {name: find_run(run_name, runs) for name, run_name in partners.items()}
    with shown_progress() as progress:
        path, registry = find_run(run, runs), lab_registry(station)
        analysed = analyse_run(path, registry, partner_paths, progress=progress.analysing)
    content = document(analysed)
    if out is not None:
        text = json.dumps(content, ensure_ascii=False, indent=2, allow_nan=False)
        write_whole(out, f"{text}\n".encode())
        message(f"Wrote {out}.")
    if as_json:
        result_json(content)
    else:
        result(f"{identity(content)}\n\n{summary(content)}")
    return verdict_code(analysed)
