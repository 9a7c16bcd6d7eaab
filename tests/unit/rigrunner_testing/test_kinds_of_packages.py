"""A package adds a kind of plugins, with the checks for it."""

from __future__ import annotations

import sys
from importlib.metadata import EntryPoint

import pytest

from helpers_cli import call
from rigrunner.api.hooks import KindRecord, PluginRecord
from rigrunner.registry import Plugin, Provider, Registry, load_registry, with_drop_ins
from rigrunner.run import lab_plugins
from rigrunner_testing import State, checks, examine_one, subject

KIND_MODULE = """
from collections.abc import Callable
from dataclasses import dataclass

from rigrunner.api import KindRecord, hookimpl
from rigrunner.api.hooks import PluginRecord
from rigrunner_testing import Subject
from rigrunner_testing.check import check, demand

api_version = 1


@dataclass(frozen=True, kw_only=True)
class LubricantRecord(PluginRecord):
    factory: Callable[..., object]
    grams: float


@check(fix="give as many grams as the bearing has room for")
def fits_into_the_bearing(subject):
    "At most ten grams go into a bearing."
    demand(subject.any_record.grams <= 10, f"it has {subject.any_record.grams} g")


CHECKS = (fits_into_the_bearing,)
SUBJECT = Subject


@hookimpl
def rigrunner_kinds():
    return [
        KindRecord(
            name="lubricant",
            help="What is between ring and ball",
            hook="rigrunner_lubricants",
            record=LubricantRecord,
            takes=("bearing",),
            conformance="lubricant_maker",
        )
    ]
"""
PLUGIN_MODULE = """
from lubricant_maker import LubricantRecord
from rigrunner.api import hookimpl

api_version = 1


def grease(bearing):
    return bearing


@hookimpl
def rigrunner_lubricants():
    return [LubricantRecord(name="grease", help="Grease.", grams={grams}, factory={factory})]
"""


def plugin_module(grams=3.0, factory="lambda settings: grease"):
    return PLUGIN_MODULE.format(grams=grams, factory=factory)


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Return a function that loads these modules as providers, in order of their names."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def load(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.py").write_text(text)
        return load_registry([EntryPoint(name, name, "rigrunner") for name in texts])

    yield load
    for name in ("lubricant_maker", "a_user", "other_maker"):
        sys.modules.pop(name, None)


def test_plugins_of_a_package_kind_are_loaded_and_made(installed):
    """The provider of the plugin is loaded before that of the kind."""
    registry = installed(a_user=plugin_module(), lubricant_maker=KIND_MODULE)
    assert registry.disabled == ()
    assert registry.kinds[-1].name == "lubricant"
    assert registry.names("lubricant") == ["grease"]
    assert registry.make("lubricant", "grease", {})("ours") == "ours"


def test_lab_file_may_provide_a_plugin_of_a_package_kind(installed, tmp_path):
    installed_registry = installed(lubricant_maker=KIND_MODULE)
    lab = tmp_path / "plugins"
    lab.mkdir()
    (lab / "grease.py").write_text(plugin_module())
    registry = with_drop_ins(installed_registry, lab)
    assert registry.disabled == ()
    assert registry.names("lubricant") == ["grease"]


def test_hook_is_unknown_without_the_package(installed, tmp_path):
    (tmp_path / "lubricant_maker.py").write_text(KIND_MODULE)
    (disabled,) = installed(a_user=plugin_module()).disabled
    assert "rigrunner_lubricants" in disabled.reason
    assert "is not the name of a hook" in disabled.reason


def test_record_of_another_kind_is_refused(installed):
    source = plugin_module().replace("LubricantRecord(", "FitRecord(").replace("grams=3.0, ", "")
    source = source.replace("import hookimpl", "import FitRecord, hookimpl")
    (disabled,) = installed(a_user=source, lubricant_maker=KIND_MODULE).disabled
    assert "rigrunner_lubricants returned a FitRecord, expected a LubricantRecord" in str(disabled)


def test_first_provider_of_a_kind_wins(installed):
    other = KIND_MODULE.replace("ring and ball", "housing and ring")
    registry = installed(lubricant_maker=KIND_MODULE, other_maker=other)
    (disabled,) = registry.disabled
    assert disabled.provider.name == "other_maker"
    assert "another plugin brings the kind 'lubricant'" in disabled.reason


def test_kind_with_a_hook_of_rigrunner_is_refused(installed):
    (disabled,) = installed(
        lubricant_maker=KIND_MODULE.replace("rigrunner_lubricants", "rigrunner_fits")
    ).disabled
    assert "another plugin brings the kind 'lubricant' or rigrunner_fits" in disabled.reason


@pytest.mark.parametrize("keyword", ['hook="rigrunner_lubricants"', "record=LubricantRecord"])
def test_kind_without_hook_or_record_is_refused(installed, keyword):
    source = KIND_MODULE.replace(keyword, f"{keyword.partition('=')[0]}=None")
    (disabled,) = installed(lubricant_maker=source).disabled
    assert "expected the name of a function and a subclass of PluginRecord" in disabled.reason


def test_failing_kinds_hook_is_reported_once(installed):
    source = KIND_MODULE.replace("    return [\n", "    raise SystemExit(3)\n    return [\n")
    (disabled,) = installed(lubricant_maker=source).disabled
    assert "SystemExit: 3" in disabled.reason


@pytest.mark.parametrize(
    ("grams", "factory", "name", "state"),
    [
        (3.0, "lambda settings: grease", "fits_into_the_bearing", State.PASS),
        (30.0, "lambda settings: grease", "fits_into_the_bearing", State.FAIL),
        (3.0, "lambda settings: grease", "can_be_made", State.PASS),
        (3.0, "lambda settings: (lambda: 1)", "can_be_made", State.FAIL),
    ],
)
def test_kit_runs_the_checks_of_a_package_kind(installed, grams, factory, name, state):
    registry = installed(lubricant_maker=KIND_MODULE, a_user=plugin_module(grams, factory))
    check = {check.name: check for check in checks("lubricant", registry)}[name]
    finding = examine_one(subject("lubricant", "grease", registry=registry), check)
    assert finding.state is state, finding.text


def kind(**changes):
    fields = {"name": "oil", "help": "Oil.", "hook": "rigrunner_oils", "record": PluginRecord}
    return Registry([Plugin("kind", KindRecord(**fields | changes), Provider("lab", "1"))])


BROKEN = {
    "hook_is_named_as_hooks_are": {"hook": "oils"},
    "brings_checks": {"conformance": "no.such.module"},
}
"""By check, the wrong field of a kind that fails it."""


@pytest.mark.parametrize("name", BROKEN)
def test_kit_fails_a_broken_kind(name):
    kind_checks = {check.name: check for check in checks("kind")}
    assert set(BROKEN) < set(kind_checks)
    valid = {"conformance": "rigrunner_bearings.conformance"}
    for changes, state in ((valid, State.PASS), (valid | BROKEN[name], State.FAIL)):
        finding = examine_one(subject("kind", "oil", registry=kind(**changes)), kind_checks[name])
        assert finding.state is state, finding.text


@pytest.mark.parametrize(("name", "message"), [("json", "has no attribute 'CHECKS'")])
def test_module_without_checks_is_reported(name, message):
    brings_checks = {check.name: check for check in checks("kind")}["brings_checks"]
    finding = examine_one(subject("kind", "oil", registry=kind(conformance=name)), brings_checks)
    assert finding.state is State.FAIL
    assert message in finding.text


def test_plugins_are_listed_under_the_plural_of_their_kind(installed, monkeypatch):
    registry = installed(lubricant_maker=KIND_MODULE, a_user=plugin_module())
    monkeypatch.setattr(lab_plugins, "load_registry", lambda: registry)
    lines = call("plugins").out.splitlines()
    assert lines[-2:] == ["lubricants of a_user", "  grease  Grease."]
    assert "kinds of lubricant_maker" in lines
