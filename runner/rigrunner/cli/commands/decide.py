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
    from collections.abc import Sequence

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
    help="The setting `fraction` of the rule, such as guard_band_fraction: w = R times U.",
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
    from rigrunner.run.lab_plugins import lab_registry
    from rigrunner.run.stored import verdict_code

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
    record, decided = decide_again(
        find_run(run, runs),
        registry,
        decider,
        lambda acceptance, names: (
            _from_file(file, registry, names) if file else _other_rule(acceptance, rule, fraction)
        ),
    )
    if as_json:
        result_json(dict(record.document))
    else:
        facts = _facts(record)
        if decided.limits.missed:
            facts.append(("the run", f"FAIL all the same. {decided.limits.reason}"))
        result(pairs(facts))
    return verdict_code(decided)


def _from_file(path: Path, registry: Registry, analyses: Sequence[str]) -> Acceptance:
    from rigrunner.plan import check_rule
    from rigrunner.procedure import AcceptanceFile, kinds_of
    from rigrunner.procedure.kinds import ASKED, KINDS
    from rigrunner.yamlfile import read, validate
    from rigrunner.yamlfile.upgrade import refuse_older

    document = read(path)
    refuse_older(document)
    context = {KINDS: kinds_of(registry), ASKED: analyses}
    acceptance = validate(AcceptanceFile, document, context=context).acceptance
    check_rule(document, acceptance, registry)
    return acceptance


def _other_rule(limits: Acceptance | None, rule: str | None, fraction: float | None) -> Acceptance:
    """Return the limits in force with another rule; raise UsageError."""
    from rigrunner.procedure import Acceptance
    from rigrunner.procedure.kinds import STORED

    if limits is None:
        hint = "give limits and rule with --acceptance FILE"
        raise UsageError("the run has no limits to which a rule could apply", hint=hint)
    changed = {**limits.as_written(), "rule": rule, "fraction": fraction}
    return Acceptance.model_validate(changed, context={STORED: True})


def _facts(record: DecisionFile) -> list[tuple[str, str]]:
    summary = record.summary
    before = f"{summary.verdict_before.upper()} ({summary.rule_before}; {summary.limit_before})"
    decision = record.document["decision"]
    probability = decision["probability_of_conformity"]
    conformity = "not determined" if probability is None else probability_text(probability)
    return [
        ("run", record.document["run"]["id"]),
        ("before", before),
        ("verdict", f"{summary.verdict.upper()}: {summary.reason}"),
        ("probability of conformity", conformity),
        ("risk", stated_risk(decision)),
        ("rule", summary.rule),
        ("limit", f"{summary.limit_text} ({summary.limit_source})"),
        ("decided by", f"{summary.by}, {summary.decided_utc}"),
        ("reason", summary.why),
        ("on record in", str(record.path)),
    ]
