from __future__ import annotations

import json
from typing import Literal

import pytest

from helpers_cli import call
from rigrunner.api.errors import ExitCode
from rigrunner.api.hooks import FitRecord, OutlierRuleRecord
from rigrunner.api.settings import Settings, Torque
from rigrunner.cli.commands import plugins
from rigrunner.registry import DisabledPlugin, Plugin, Provider, Registry

LAB = Provider("lab_plugins", "2.0")


class Inner(Settings):
    limit: Torque
    side: Literal["both", "high"] = "both"


class Outer(Settings):
    inner: Inner


@pytest.fixture
def registry(monkeypatch):
    def none(settings):
        raise NotImplementedError

    records = [
        Plugin("fit", FitRecord(name="spline", help="A spline.", factory=none), LAB),
        Plugin(
            "outlier_rule",
            OutlierRuleRecord(name="pauta", help="Three sigma.", factory=none, settings=Outer),
            LAB,
        ),
    ]
    disabled = [DisabledPlugin(Provider("broken", "0.1"), "ImportError: no driver")]
    monkeypatch.setattr(plugins, "load_registry", lambda: Registry(records, disabled))


@pytest.mark.usefixtures("registry")
def test_plugins_are_listed_by_kind():
    called = call("plugins")
    assert called.code == ExitCode.PASS
    assert called.out == ("outlier rules\n  pauta  Three sigma.\n\nfits\n  spline  A spline.\n")


@pytest.mark.usefixtures("registry")
def test_a_plugin_that_could_not_be_loaded_is_named_with_its_reason():
    assert "disabled: broken 0.1: ImportError: no driver" in call("plugins").err


@pytest.mark.usefixtures("registry")
def test_settings_are_shown_with_those_of_nested_models():
    lines = call("plugins", "pauta").out.splitlines()
    assert lines[:2] == ["outlier rule 'pauta' of lab_plugins 2.0", "Three sigma."]
    assert lines[3].startswith("  inner.limit  ")
    assert "N·m" in lines[3]
    assert lines[3].endswith("(required)")
    assert lines[4] == "  inner.side   both | high (default: both)"


@pytest.mark.usefixtures("registry")
def test_a_plugin_without_settings_says_so():
    assert "nothing to set" in call("plugins", "spline").out


@pytest.mark.usefixtures("registry")
def test_programs_get_the_schema():
    (found,) = json.loads(call("plugins", "pauta", "--json").out)
    assert (found["kind"], found["provider"], found["version"]) == (
        "outlier_rule",
        "lab_plugins",
        "2.0",
    )
    assert "inner" in found["settings"]["properties"]


@pytest.mark.usefixtures("registry")
def test_an_unknown_plugin_gets_a_suggestion():
    called = call("plugins", "splin")
    assert called.code == ExitCode.INVALID
    assert "did you mean 'spline'?" in called.err
