from __future__ import annotations

import json
from typing import Annotated, Literal

import pytest
from pydantic import Field

from helpers_cli import call
from rigrunner.api.errors import ExitCode
from rigrunner.api.hooks import FitRecord, OutlierRuleRecord
from rigrunner.api.settings import Ratio, Settings, Torque
from rigrunner.registry import DisabledPlugin, Plugin, Provider, Registry
from rigrunner.run import lab_plugins

LAB = Provider("lab_plugins", "2.0")


class Inner(Settings):
    limit: Torque
    """The highest torque."""
    span: Annotated[Ratio, Field(gt=0, le=1, description="of full scale")] = 0.05
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
    monkeypatch.setattr(lab_plugins, "load_registry", lambda: Registry(records, disabled))


@pytest.mark.usefixtures("registry")
def test_plugins_are_listed_by_kind():
    result = call("plugins")
    assert result.code == ExitCode.PASS
    assert result.out == (
        "outlier rules of lab_plugins 2.0\n  pauta  Three sigma.\n\n"
        "fits of lab_plugins 2.0\n  spline  A spline.\n"
    )


@pytest.mark.usefixtures("registry")
def test_disabled_plugin_is_shown_with_its_reason():
    assert "disabled: broken 0.1: ImportError: no driver" in call("plugins").err


@pytest.mark.usefixtures("registry")
def test_settings_of_nested_models_are_shown():
    assert call("plugins", "pauta").out.splitlines() == [
        "outlier rule 'pauta' of lab_plugins 2.0",
        "Three sigma.",
        "",
        "  inner.limit: (required)",
        "      The highest torque (torque in N·m or mN·m or in·lbf)",
        "  inner.span: 5 %",
        "      of full scale (ratio in 1 or %, more than 0, at most 100 %)",
        "  inner.side: both",
        "      (both | high)",
    ]


@pytest.mark.usefixtures("registry")
def test_plugin_without_settings_is_shown_as_such():
    assert "no settings" in call("plugins", "spline").out


@pytest.mark.usefixtures("registry")
def test_json_has_parameters_and_schema():
    (plugin,) = json.loads(call("plugins", "pauta", "--json").out)
    assert (plugin["kind"], plugin["provider"], plugin["version"]) == (
        "outlier_rule",
        "lab_plugins",
        "2.0",
    )
    assert "inner" in plugin["settings"]["properties"]
    assert plugin["parameters"][1] == {
        "name": "inner.span",
        "kind": "ratio",
        "units": ["1", "%"],
        "bounds": "more than 0, at most 100 %",
        "default": "5 %",
        "required": False,
        "help": "of full scale",
    }


@pytest.mark.usefixtures("registry")
def test_unknown_plugin_gets_a_suggestion():
    result = call("plugins", "splin")
    assert result.code == ExitCode.USAGE
    assert "did you mean 'spline'?" in result.err
