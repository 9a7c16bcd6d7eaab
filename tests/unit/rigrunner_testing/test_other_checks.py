"""Each check of the other kinds of plugin fails a plugin that is broken in that way.

The shipped plugins are checked by tests/contract/test_conformance.py.
"""

from __future__ import annotations

import pytest

from rigrunner.api.verdict import Verdict, Zone
from rigrunner_testing import State, checks, examine, examine_one, subject
from rigrunner_testing.settings import CHECKS as OF_EVERY_PLUGIN
from unit.rigrunner_plugins.devices.helpers_conformance import SCANS
from unit.rigrunner_testing.helpers_zoo_analysis import (
    DECISION_RULES,
    FITS,
    RULES,
    DecisionRule,
    decision_rule_registry,
    fit_registry,
    grubbs,
    line,
    proven,
    rule_registry,
)
from unit.rigrunner_testing.helpers_zoo_files import (
    FORMATS,
    IMPORTERS,
    SINKS,
    Table,
    format_registry,
    importer_registry,
    is_slow_later,
    listener,
    looks_up_a_font,
    page,
    sink_registry,
    zeroes_the_angle,
)
from unit.rigrunner_testing.helpers_zoo_results import (
    ANALYSES,
    analysis_registry,
    without_uncertainty,
)
from unit.rigrunner_testing.helpers_zoo_units import UNITS, good_unit_registry, unit_registry


def own_checks(kind):
    return {check.name: check for check in checks(kind) if check not in OF_EVERY_PLUGIN}


def finding_of(kind, name, registry):
    return examine_one(
        subject(kind, registry.plugins[0].record.name, registry=registry), own_checks(kind)[name]
    )


BROKEN_BY_KIND = {
    "fit": (FITS, fit_registry),
    "outlier_rule": (RULES, rule_registry),
    "decision_rule": (DECISION_RULES, decision_rule_registry),
    "report_format": (FORMATS, format_registry),
    "event_sink": (SINKS, sink_registry),
    "importer": (IMPORTERS, importer_registry),
    "analysis": (ANALYSES, lambda make: make()),
    "unit": (UNITS, unit_registry),
}
BROKEN = [(kind, name) for kind, (zoo, _) in BROKEN_BY_KIND.items() for name in zoo]
GOOD = {
    "fit": lambda: fit_registry(line, examples=()),
    "outlier_rule": lambda: rule_registry(grubbs, examples=()),
    "decision_rule": lambda: decision_rule_registry(DecisionRule(proven)),
    "report_format": lambda: format_registry(page),
    "event_sink": lambda: sink_registry(listener),
    "importer": lambda: importer_registry(Table),
    "analysis": analysis_registry,
    "unit": good_unit_registry,
}


@pytest.mark.parametrize("kind", BROKEN_BY_KIND)
def test_every_check_has_a_broken_plugin(kind):
    assert set(BROKEN_BY_KIND[kind][0]) == set(own_checks(kind))


def test_certificates_have_the_checks_of_reports():
    assert own_checks("certificate_format") == own_checks("report_format")


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        pytest.param(
            *case, marks=[pytest.mark.thorough] * (case == ("report_format", "makes_a_file"))
        )
        for case in BROKEN
    ],
)
def test_broken_plugin_fails(kind, name):
    zoo, registry = BROKEN_BY_KIND[kind]
    finding = finding_of(kind, name, registry(zoo[name]))
    assert finding.state is State.FAIL
    assert finding.text


@pytest.mark.parametrize("sink", [is_slow_later, zeroes_the_angle])
def test_every_event_and_channel_is_checked(sink):
    name = "comes_back_at_once" if sink is is_slow_later else "leaves_samples_alone"
    assert finding_of("event_sink", name, sink_registry(sink)).state is State.FAIL


def test_format_that_tolerates_a_missing_network_fails():
    finding = finding_of("report_format", "nothing_is_fetched", format_registry(looks_up_a_font))
    assert finding.text == "making it did: socket.getaddrinfo"


def test_coverage_without_uncertainty_is_not_applicable():
    registry = analysis_registry(without_uncertainty)
    finding = finding_of("analysis", "covers_the_truth", registry)
    assert (finding.state, finding.text) == (State.NOT_APPLICABLE, "it states no uncertainty")


def test_risks_of_a_rule_that_never_fails_are_not_judged():
    rule = DecisionRule(lambda *_: [Zone(Verdict.PASS, 0.1, "w"), Zone(Verdict.INCONCLUSIVE, -9.0)])
    registry = decision_rule_registry(rule)
    findings = examine(subject("decision_rule", "rule", registry=registry), checks("decision_rule"))
    states = {finding.check.name: finding.state for finding in findings}
    assert states["passes_the_good_and_fails_the_bad"] is State.FAIL
    assert states["stated_risks_are_those_of_its_verdicts"] is State.NOT_JUDGED


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        # the shipped rules pass them too
        pytest.param(kind, name, marks=[pytest.mark.thorough] * (name in SCANS))
        for kind, name in BROKEN
    ],
)
def test_conforming_plugin_passes(kind, name):
    finding = finding_of(kind, name, GOOD[kind]())
    assert finding.state is not State.FAIL, finding.text
