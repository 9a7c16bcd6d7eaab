"""`rigrunner decide`: decide a stored run by another rule or other limits."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.api.errors import PluginError, UsageError
from rigrunner.api.summaries import pairs
from rigrunner.api.verdict import probability_text
from rigrunner.cli.completing import decision_rules
from rigrunner.cli.options import json_option, lab_option, run_argument, runs_option
from rigrunner.cli.output import result, result_json
from rigrunner.cli.summary import stated_risk
from rigrunner.run.locate import find_run

if TYPE_CHECKING:
    from rigrunner.api.errors import ExitCode
    from rigrunner.procedure import Acceptance
    from rigrunner.registry import Registry
    from rigrunner.run.decisions import DecisionFile


@click.command(name="decide")
@run_argument
@runs_option
@lab_option
@click.option(
    "--acceptance",
    "file",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Limits and rule from a YAML file.",
)
@click.option(
    "--rule",
    shell_complete=decision_rules,
    metavar="NAME",
    help="Another rule, for the present limits.",
)
@click.option(
    "--fraction",
    type=float,
    metavar="R",
    help="The setting of that name, such as of guard_band_fraction: w = R times U.",
)
@click.option("--by", required=True, metavar="NAME", help="Who decides.")
@click.option("--reason", required=True, metavar="TEXT", help="Why it is decided again.")
@json_option
def command(
    *,
    run: str,
    runs: Path,
    station: str | None,
    file: Path | None,
    rule: str | None,
    fraction: float | None,
    by: str,
    reason: str,
    as_json: bool,
) -> ExitCode:
    """Decide a stored run again, by another rule or other limits.

    Nothing is measured again and no file is changed. The decision is stored beside the run with
    name, time and reason, and is in its report.
    """
    from rigrunner.clock import WallClock
    from rigrunner.run.decisions import Decider, decide_again
    from rigrunner.run.finish import verdict_code
    from rigrunner.run.lab_plugins import lab_registry

    if (file is None) == (rule is None):
        raise UsageError("give either --acceptance FILE or --rule RULE")
    if rule is None and fraction is not None:
        raise UsageError("--fraction is a setting of --rule", hint="give both, or a file")
    registry = lab_registry(station)
    if rule is not None:
        settings = {} if fraction is None else {"fraction": fraction}
        try:
            registry.validated("decision_rule", rule, settings)
        except PluginError as error:
            hint = error.hint or "such as --rule guard_band_fraction --fraction 0.5, for w = U/2"
            raise UsageError(f"--rule: {error.message}", hint=hint) from error
    decider = Decider(by=by, reason=reason, at=WallClock().utc())
    written, found = decide_again(
        find_run(run, runs),
        registry,
        decider,
        lambda held: _from_file(file, registry) if file else _other_rule(held, rule, fraction),
    )
    if as_json:
        result_json(dict(written.document))
    else:
        facts = _facts(written)
        if found.limits.missed:
            facts.append(("the run", f"FAIL all the same. {found.limits.reason}"))
        result(pairs(facts))
    return verdict_code(found)


def _from_file(path: Path, registry: Registry) -> Acceptance:
    from rigrunner.plan import check_rule
    from rigrunner.procedure import AcceptanceFile, kinds_of
    from rigrunner.procedure.kinds import KINDS
    from rigrunner.yamlfile import read, validate
    from rigrunner.yamlfile.upgrade import refuse_older

    document = read(path)
    refuse_older(document)
    acceptance = validate(AcceptanceFile, document, context={KINDS: kinds_of(registry)}).acceptance
    check_rule(document, acceptance, registry)
    return acceptance


def _other_rule(held: Acceptance | None, rule: str | None, fraction: float | None) -> Acceptance:
    """Return the limits in force with another rule; raise UsageError."""
    from rigrunner.procedure import Acceptance
    from rigrunner.procedure.kinds import STORED

    if held is None:
        hint = "give limits and rule with --acceptance FILE"
        raise UsageError("the run has no limits to which a rule could apply", hint=hint)
    changed = {**held.as_written(), "rule": rule, "fraction": fraction}
    return Acceptance.model_validate(changed, context={STORED: True})


def _facts(written: DecisionFile) -> list[tuple[str, str]]:
    found = written.summary
    decision = written.document["decision"]
    probability = decision["probability_of_conformity"]
    stated = "not determined" if probability is None else probability_text(probability)
    return [
        ("run", written.document["run"]["id"]),
        ("before", f"{found.verdict_before.upper()} ({found.rule_before}; {found.limit_before})"),
        ("verdict", f"{found.verdict.upper()}: {found.reason}"),
        ("probability of conformity", stated),
        ("risk", stated_risk(decision)),
        ("rule", found.rule),
        ("limit", f"{found.limit_text} ({found.limit_source})"),
        ("decided by", f"{found.by}, {found.decided_utc}"),
        ("reason", found.why),
        ("on record in", str(written.path)),
    ]
