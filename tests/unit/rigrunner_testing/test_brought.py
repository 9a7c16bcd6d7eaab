"""A package brings a kind of plugins of its own, with what the kit checks them by."""

from __future__ import annotations

import sys
from importlib.metadata import EntryPoint

import pytest

from helpers_cli import call
from rigrunner.api.hooks import KindRecord, PluginRecord
from rigrunner.registry import Plugin, Provider, Registry, load_registry, with_drop_ins
from rigrunner.run import lab_plugins
from rigrunner_testing import State, checks, examine_one, subject

MAKER = """
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
USER = """
from lubricant_maker import LubricantRecord
from rigrunner.api import hookimpl

api_version = 1


def grease(bearing):
    return bearing


@hookimpl
def rigrunner_lubricants():
    return [LubricantRecord(name="grease", help="Grease.", grams={grams}, factory={factory})]
"""


def user(grams=3.0, factory="lambda settings: grease"):
    return USER.format(grams=grams, factory=factory)


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Give what loads modules of these texts as providers, in the order of their names."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def load(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.py").write_text(text)
        return load_registry([EntryPoint(name, name, "rigrunner") for name in texts])

    yield load
    for name in ("lubricant_maker", "a_user", "other_maker"):
        sys.modules.pop(name, None)


def test_plugins_of_a_kind_that_a_package_brings_are_found_and_made(installed):
    """Though the provider of the plugin is loaded before that of the kind."""
    registry = installed(a_user=user(), lubricant_maker=MAKER)
    assert registry.disabled == ()
    assert registry.kinds[-1].name == "lubricant"
    assert registry.names("lubricant") == ["grease"]
    assert registry.make("lubricant", "grease", {})("ours") == "ours"


def test_a_lab_s_own_file_may_bring_a_plugin_of_it(installed, tmp_path):
    installed_registry = installed(lubricant_maker=MAKER)
    lab = tmp_path / "plugins"
    lab.mkdir()
    (lab / "grease.py").write_text(user())
    registry = with_drop_ins(installed_registry, lab)
    assert registry.disabled == ()
    assert registry.names("lubricant") == ["grease"]


def test_without_the_package_its_hook_is_not_known(installed, tmp_path):
    (tmp_path / "lubricant_maker.py").write_text(MAKER)
    (disabled,) = installed(a_user=user()).disabled
    assert "rigrunner_lubricants" in disabled.reason
    assert "is not the name of a hook" in disabled.reason


def test_a_record_of_another_kind_is_refused(installed):
    source = user().replace("LubricantRecord(", "FitRecord(").replace("grams=3.0, ", "")
    source = source.replace("import hookimpl", "import FitRecord, hookimpl")
    (disabled,) = installed(a_user=source, lubricant_maker=MAKER).disabled
    assert "rigrunner_lubricants returned a FitRecord, expected a LubricantRecord" in str(disabled)


def test_a_kind_that_two_bring_is_that_of_the_first(installed):
    other = MAKER.replace("ring and ball", "housing and ring")
    registry = installed(lubricant_maker=MAKER, other_maker=other)
    (disabled,) = registry.disabled
    assert disabled.provider.name == "other_maker"
    assert "another plugin brings the kind 'lubricant'" in disabled.reason


def test_a_kind_takes_no_hook_of_rigrunner_s_own(installed):
    (disabled,) = installed(
        lubricant_maker=MAKER.replace("rigrunner_lubricants", "rigrunner_fits")
    ).disabled
    assert "another plugin brings the kind 'lubricant' or rigrunner_fits" in disabled.reason


@pytest.mark.parametrize("part", ['hook="rigrunner_lubricants"', "record=LubricantRecord"])
def test_a_kind_without_a_hook_or_a_record_is_refused(installed, part):
    source = MAKER.replace(part, f"{part.partition('=')[0]}=None")
    (disabled,) = installed(lubricant_maker=source).disabled
    assert "expected the name of a function and a subclass of PluginRecord" in disabled.reason


def test_a_broken_hook_for_kinds_is_said_once(installed):
    source = MAKER.replace("    return [\n", "    raise SystemExit(3)\n    return [\n")
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
def test_the_kit_holds_its_plugins_to_the_checks_of_the_kind(
    installed, grams, factory, name, state
):
    registry = installed(lubricant_maker=MAKER, a_user=user(grams, factory))
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
"""By check, what is wrong with the kind that fails it."""


@pytest.mark.parametrize("name", BROKEN)
def test_the_kit_fails_a_kind_that_is_broken(name):
    kind_checks = {check.name: check for check in checks("kind")}
    assert set(BROKEN) < set(kind_checks)
    valid = {"conformance": "rigrunner_bearings.conformance"}
    for changes, state in ((valid, State.PASS), (valid | BROKEN[name], State.FAIL)):
        finding = examine_one(subject("kind", "oil", registry=kind(**changes)), kind_checks[name])
        assert finding.state is state, finding.text


@pytest.mark.parametrize(("name", "message"), [("json", "has no attribute 'CHECKS'")])
def test_a_module_without_checks_is_named(name, message):
    brings_checks = {check.name: check for check in checks("kind")}["brings_checks"]
    finding = examine_one(subject("kind", "oil", registry=kind(conformance=name)), brings_checks)
    assert finding.state is State.FAIL
    assert message in finding.text


def test_plugins_are_listed_by_their_kind_in_its_plural(installed, monkeypatch):
    registry = installed(lubricant_maker=MAKER, a_user=user())
    monkeypatch.setattr(lab_plugins, "load_registry", lambda: registry)
    lines = call("plugins").out.splitlines()
    assert lines[-2:] == ["lubricants of a_user", "  grease  Grease."]
    assert "kinds of lubricant_maker" in lines
