"""`rigrunner check-plugin`: run the conformance kit on one plugin."""

from __future__ import annotations

import sys
from collections import Counter
from contextlib import ExitStack
from dataclasses import replace
from itertools import chain
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import ExitCode, PluginError, UsageError
from rigrunner.cli.completing import plugin_names, stations
from rigrunner.cli.options import json_option
from rigrunner.cli.output import message, result, result_json

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.registry import DisabledPlugin, Registry
    from rigrunner_testing import AnyCheck, Finding, Subject

WIDTH = 96
INDENT = " " * 8
LOADED = "It can be loaded, and its hooks return its records."
LABELS = {"pass": "pass", "fail": "FAIL", "not applicable": "n/a"}


@click.command(name="check-plugin")
@click.argument("name", shell_complete=plugin_names)
@click.option("--kind", help="Its kind, such as device or fit, if several kinds have the name.")
@click.option(
    "--settings",
    "settings_file",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    help="A YAML file with settings for the check.",
)
@click.option(
    "--drop-in",
    type=click.Path(path_type=Path, exists=True, file_okay=False),
    help="Include the plugins of this folder.",
)
@click.option(
    "--station", shell_complete=stations, help="Check a device with the settings of this station."
)
@click.option("--role", help="The device's role in the station.")
@click.option("--read-only", is_flag=True, help="Leave out the checks that set drives.")
@click.option("--yes", is_flag=True, help="Do not ask before drives of a real device are set.")
@json_option
def command(
    name: str,
    *,
    kind: str | None,
    settings_file: Path | None,
    drop_in: Path | None,
    station: str | None,
    role: str | None,
    read_only: bool,
    yes: bool,
    as_json: bool,
) -> ExitCode:
    """Run the conformance checks on a plugin.

    Each failed requirement comes with a fix; checks that depend on a failed one are left out. By
    default the settings are those under `trial` of its record. The exit code is 1 if a check fails.
    """
    if (station is None) != (role is None):
        raise UsageError("--station and --role go together", hint="--station rig.yaml --role press")
    if station is not None and (settings_file or drop_in):
        raise UsageError("a station has its own settings and plugins", hint="leave the others out")
    from rigrunner.cli.stopping import stop_on_signals

    with ExitStack() as stack:
        if station is not None and role is not None:
            from rigrunner.run.locate import find_station
            from rigrunner_testing.station import bound_subject

            device = bound_subject(find_station(station), role, name)
            subjects: Sequence[Subject] = [stack.enter_context(device)]
        else:
            from rigrunner.registry import load_registry, with_drop_ins

            registry = load_registry()
            if drop_in is not None:
                registry = with_drop_ins(registry, drop_in)
            unloaded = registry.disabled_with(name)
            if unloaded is not None and not _kinds(registry, name):
                return _not_loaded(name, unloaded, as_json=as_json)
            subjects = _installed(registry, name, kind, settings_file)
        stop = stack.enter_context(stop_on_signals())
        stack.enter_context(stop.while_asking())  # a signal breaks a check off, as Ctrl-C does
        findings = [
            _run_checks(subject, read_only=read_only, yes=yes, quiet=as_json)
            for subject in subjects
        ]
    if as_json:
        result_json([_document(*pair) for pair in zip(subjects, findings, strict=True)])
    failed = any(finding.state == "fail" for finding in chain.from_iterable(findings))
    return ExitCode.FAIL if failed else ExitCode.PASS


def _kinds(registry: Registry, name: str) -> list[str]:
    return [plugin.kind for plugin in registry.plugins if plugin.record.name == name]


def _not_loaded(name: str, unloaded: DisabledPlugin, *, as_json: bool) -> ExitCode:
    """Report why a plugin cannot be loaded, in the form of a failed check."""
    problem = unloaded.reason.removesuffix(f" ({unloaded.fix})")
    fix = unloaded.fix or "see where its hooks are, and what they return"
    provider = str(unloaded.provider)
    if as_json:
        check = _check_document("is_loaded", "fail", LOADED, problem, fix)
        result_json([{"kind": "", "name": name, "provider": provider, "findings": [check]}])
    else:
        result(f"'{name}' of {provider}")
        result(_failure("is_loaded", LOADED, problem, fix))
        result("\n0 pass, 1 fail, 0 not applicable; fix that first; no other check was made")
    return ExitCode.FAIL


def _installed(
    registry: Registry, name: str, kind: str | None, settings_file: Path | None
) -> list[Subject]:
    """Return the plugins of that name, of that kind or of all."""
    from rigrunner_testing import subject

    kinds = _kinds(registry, name)
    if kind is not None:
        kinds = [kind]
    if not kinds:
        names = sorted({plugin.record.name for plugin in registry.plugins})
        hint = f"a file of your own: --drop-in FOLDER; {registry.suggestion(name, names)}"
        raise PluginError(f"there is no plugin '{name}'", hint=hint)
    if settings_file is not None and len(kinds) > 1:
        raise UsageError(
            f"'{name}' is a {' and a '.join(kinds)}", hint="name the kind of plugin with --kind"
        )
    settings = _settings(settings_file)
    folder = settings_file.parent if settings_file else Path()
    return [subject(kind, name, settings, registry=registry, folder=folder) for kind in kinds]


def _settings(file: Path | None) -> Mapping[str, Any] | None:
    if file is None:
        return None
    from rigrunner.yamlfile import read

    settings = read(file).data
    if not isinstance(settings, dict):
        raise UsageError(
            f"{file} holds no settings", hint="write them as under settings: of a station"
        )
    return settings


def _run_checks(subject: Subject, *, read_only: bool, yes: bool, quiet: bool) -> list[Finding]:
    """Run the checks, report each result as it ends, and leave the device safe."""
    from rigrunner_testing import State, checks, examine, examine_one

    all_checks = checks(subject.kind, subject.registry)
    selected = [check for check in all_checks if not (read_only and check.moves)]
    left_out = len(all_checks) - len(selected)
    subject = _restricted(subject, selected, read_only=read_only, yes=yes)
    if not quiet:
        result(f"{subject.kind.replace('_', ' ')} '{subject.name}' of {subject.plugin.provider}")
    findings = []
    try:
        for finding in examine(subject, selected):
            findings.append(finding)
            if not quiet and finding.state is not State.NOT_JUDGED:
                result(_line(finding))
    except BaseException:
        for check in selected:
            if check.name == "left_safe":
                message(f"interrupted; {_line(examine_one(subject, check)).strip()}")
        raise
    if not quiet:
        result(_summary(findings, left_out))
    return findings


def _restricted(
    subject: Subject, selected: Sequence[AnyCheck], *, read_only: bool, yes: bool
) -> Subject:
    """Return the subject with its restrictions; ask before drives of a real device are set."""
    from rigrunner_testing.device import DeviceSubject
    from rigrunner_testing.device.doing import set_point_at
    from rigrunner_testing.device.quantities import PARTS

    if not isinstance(subject, DeviceSubject):
        return subject
    if read_only:
        return replace(subject, read_only=True)
    drives = [] if subject.simulated else subject.drives_of(subject.make())
    if not drives:
        return subject
    moving = ", ".join(check.name for check in selected if check.moves)
    ranges = "; ".join(
        f"{drive.name} up to {set_point_at(drive, max(PARTS)):g} {drive.unit}" for drive in drives
    )
    message(fill(f"This is not a simulator. These checks set its drives: {moving}.", WIDTH))
    message(fill(f"They move {ranges}; set-points beyond the limits are tried too.", WIDTH))
    message("No interlock is watched meanwhile. --read-only leaves these checks out.")
    if not yes and not sys.stdin.isatty():
        raise UsageError(
            "no one can confirm that its drives may move", hint="give --yes or --read-only"
        )
    if not yes:
        click.confirm("Is the rig clear, so that its drives may move?", abort=True, err=True)
    return subject


def _line(finding: Finding) -> str:
    head = f"{LABELS[finding.state]:4}  {finding.check.name}"
    if finding.state == "pass":
        return head
    if finding.state == "not applicable":
        return f"{head}: {finding.text}"
    return _failure(finding.check.name, finding.check.holds, finding.text, finding.fix)


def _failure(name: str, holds: str, problem: str, fix: str) -> str:
    texts = (holds, f"found: {problem}", f"fix: {fix}")
    return "\n".join([f"FAIL  {name}", *(_wrapped(text) for text in texts)])


def _wrapped(text: str) -> str:
    return fill(  # a path stays in one piece, so that it can be clicked
        text,
        WIDTH,
        initial_indent=INDENT,
        subsequent_indent=f"{INDENT}  ",
        break_on_hyphens=False,
        break_long_words=False,
    )


def _summary(findings: Sequence[Finding], left_out: int) -> str:
    count = Counter(finding.state for finding in findings)
    counts = [f"{count[state]} {state}" for state in ("pass", "fail", "not applicable")]  # type: ignore[index]  # a StrEnum
    remarks = f"; {left_out} left out, as they set drives" if left_out else ""
    not_judged = count["not judged"]  # type: ignore[index]  # a StrEnum
    remarks += f"; {not_judged} not made until the failures are fixed" if not_judged else ""
    return f"\n{', '.join(counts)}{remarks}"


def _document(subject: Subject, findings: Sequence[Finding]) -> dict[str, Any]:
    return {
        "kind": subject.kind,
        "name": subject.name,
        "provider": str(subject.plugin.provider),
        "findings": [
            _check_document(
                finding.check.name, finding.state, finding.check.holds, finding.text, finding.fix
            )
            for finding in findings
        ],
    }


def _check_document(name: str, state: str, holds: str, problem: str, fix: str) -> dict[str, str]:
    return {"check": name, "state": str(state), "holds": holds, "found": problem, "fix": fix}
