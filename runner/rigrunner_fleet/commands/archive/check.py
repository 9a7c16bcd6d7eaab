"""`rigrunner archive check`: check that every file is unchanged."""

from __future__ import annotations

import re
from contextlib import closing
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import AbortedError, ExitCode, UsageError
from rigrunner.cli.batch import shown_count
from rigrunner.cli.options import json_option, runs_option
from rigrunner.cli.output import result, result_json
from rigrunner_fleet.cli.archiving import database_option

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner_fleet.archive.checking import CheckSummary

_RATE = re.compile(r"(\d+(?:\.\d+)?) ?([kMG]?)B/s")
_POWERS = {"": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}


@click.command(name="check")
@runs_option
@database_option
@click.option(
    "--rate",
    default="50 MB/s",
    show_default=True,
    metavar="RATE",
    help="Read no faster than this.",
)
@click.option("--for", "duration", metavar="TIME", help="Stop after this time, such as '6 h'.")
@click.option(
    "--older", metavar="TIME", help="Leave out runs checked within this time, such as '30 d'."
)
@json_option
def command(
    *, runs: Path, database: str, rate: str, duration: str | None, older: str | None, as_json: bool
) -> ExitCode:
    """Read all files of an archive, and list damaged, missing, changed and unknown ones.

    The files checked longest ago come first, and progress is kept: you can stop it at any time. The
    exit code is 1 if a file is damaged, missing or changed.
    """
    from datetime import UTC, datetime, timedelta

    from rigrunner.cli.stopping import batch_stop_on_signals, until
    from rigrunner.jobs import Processes
    from rigrunner_fleet.archive import open_archive
    from rigrunner_fleet.archive.checking import Pace, RunChecker, check

    pace = Pace(_bytes_per_s(rate))
    limit_s = _seconds("--for", duration)
    age_s = _seconds("--older", older)
    before = None if age_s is None else datetime.now(UTC) - timedelta(seconds=age_s)
    with (
        closing(open_archive(runs, database)) as archive,
        batch_stop_on_signals() as stop,
        shown_count("runs") as progress,
    ):
        summary = check(
            archive,
            RunChecker(pace),
            Processes(1),
            until(stop, limit_s),
            now=lambda: datetime.now(UTC),
            before=before,
            progress=progress,
        )
        _show(summary, as_json=as_json)
        if stop.is_set():
            raise AbortedError(
                f"{summary.checked} of {summary.due} runs were checked",
                hint="findings are kept: the same command continues with the rest",
            )
    return ExitCode.FAIL if summary.grave else ExitCode.PASS


def _show(summary: CheckSummary, *, as_json: bool) -> None:
    if as_json:
        result_json(_document(summary))
        return
    for finding in summary.findings:
        result(f"{finding.kind:8} {finding.path}{f': {finding.what}' if finding.what else ''}")
    result(_conclusion(summary))


def _conclusion(summary: CheckSummary) -> str:
    rate = summary.read_bytes / summary.seconds / 1e6 if summary.seconds else 0.0
    left = f" of {summary.due} that were due" if summary.checked < summary.due else ""
    runs = "1 run" if summary.checked == 1 else f"{summary.checked} runs"
    counts = f"{runs}{left}, {summary.read_bytes / 1e6:.1f} MB read at {rate:.1f} MB/s"
    count = len(summary.grave)
    conclusion = "no file is damaged, missing or changed"
    if count:
        conclusion = f"{count} file{' is' if count == 1 else 's are'} damaged, missing or changed"
    return f"{counts}: {conclusion}"


def _document(summary: CheckSummary) -> dict[str, Any]:
    return {
        "runs_looked_at": summary.checked,
        "runs_due": summary.due,
        "bytes_read": summary.read_bytes,
        "seconds": round(summary.seconds, 3),
        "findings": [
            {"path": finding.path, "kind": str(finding.kind), "what": finding.what}
            for finding in summary.findings
        ],
    }


def _bytes_per_s(text: str) -> float:
    match = _RATE.fullmatch(text.strip())
    value = float(match[1]) * _POWERS[match[2]] if match else 0.0
    if value <= 0:
        raise UsageError(
            f"'--rate {text}' is not a rate", hint="write it as '50 MB/s' or '800 kB/s'"
        )
    return value


def _seconds(option: str, text: str | None) -> float | None:
    from rigrunner.api.quantity import entered_si

    if text is None:
        return None
    seconds = entered_si(option, text, "time")
    if seconds <= 0:
        raise UsageError(f"{option}: '{text}' is not longer than 0")
    return seconds
