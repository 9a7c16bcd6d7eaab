"""`rigrunner doctor`: check whether this machine is fit to measure."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import click

from rigrunner.api.errors import ExitCode
from rigrunner.api.summaries import pairs
from rigrunner.cli.options import json_option, lab_option, runs_option
from rigrunner.cli.output import result, result_json
from rigrunner.run.locate import find_station

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="doctor")
@runs_option
@lab_option
@json_option
def command(runs: Path, station: str | None, *, as_json: bool) -> ExitCode:
    """Check the installation and the machine, and suggest fixes.

    The exit code is 1 if a required part does not work.
    """
    from rigrunner.run.lab_plugins import lab_registry
    from rigrunner.tools.doctor import Surroundings, examine

    station_path = find_station(station) if station is not None else None
    surroundings = Surroundings(
        runs, lab_registry(station).with_all_settings(), datetime.now(UTC), station_path
    )
    findings = examine(surroundings)
    if as_json:
        result_json([asdict(finding) for finding in findings])
    else:
        rows = []
        for finding in findings:
            rows.append((f"{finding.state:4}  {finding.name}", finding.found))
            if finding.fix:
                rows.append(("", f"fix: {finding.fix}"))
        count = Counter(finding.state for finding in findings)
        total = ", ".join(f"{count[state]} {state}" for state in ("ok", "warn", "fail"))
        result(f"{pairs(rows)}\n\n{total}")
    failed = any(finding.state == "fail" for finding in findings)
    return ExitCode.FAIL if failed else ExitCode.PASS
