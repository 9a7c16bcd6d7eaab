"""The JSON Schemas of the languages: current, complete, and in a form that editors support."""

from __future__ import annotations

import json
import re
from importlib.metadata import entry_points
from typing import get_args

import pytest

from helpers_docs import ROOT
from helpers_measurand import LimitOfColour, analysis
from rigrunner.api.hooks import PROJECT, AnalysisRecord, DeviceRecord, FitRecord
from rigrunner.api.plugin_refs import FitRef
from rigrunner.api.settings import Force, Settings
from rigrunner.procedure.kinds import installed_kinds
from rigrunner.registry import Plugin, Provider, Registry, load_registry
from rigrunner.tools.schemas.files import Language, certificate_schema, language_schema

LANGUAGES = get_args(Language)
COPIED = ("procedure", "station", "import")
SHIPPED = ("rigrunner_bearings", "rigrunner_plugins", "rigrunner_reports")


@pytest.fixture(scope="module")
def shipped():
    """Return the registry of the shipped packages only."""
    return load_registry(entry for entry in entry_points(group=PROJECT) if entry.name in SHIPPED)


@pytest.fixture(scope="module")
def procedure(shipped):
    return language_schema("procedure", shipped)


@pytest.mark.parametrize("language", COPIED)
def test_committed_schema_is_current(language, shipped):
    path = ROOT / "procedures" / f"{language}.schema.json"
    committed = json.loads(path.read_text(encoding="utf-8"))
    fix = f"run: rigrunner schema {language} > procedures/{language}.schema.json"
    assert committed == language_schema(language, shipped), fix


def test_committed_certificate_schema_is_current():
    path = ROOT / "docs" / "reference" / "certificate.schema.json"
    committed = json.loads(path.read_text(encoding="utf-8"))
    fix = f"run: rigrunner schema certificate > {path.relative_to(ROOT)}"
    assert committed == certificate_schema(), fix


@pytest.mark.parametrize("language", LANGUAGES)
def test_schema_has_only_internal_references(language, shipped):
    text = json.dumps(language_schema(language, shipped))
    references = set(re.findall(r'"\$ref": "#/\$defs/([^"]+)"', text))
    assert references == set(language_schema(language, shipped)["$defs"])
    for private in ("x-dimension", "x-plugin", '"null"'):
        assert private not in text


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_key_has_help(language, shipped):
    schema = language_schema(language, shipped)
    definitions = schema["$defs"]
    keys_without_help = []
    for name, definition in {"": schema, **definitions}.items():
        for key, spec in definition.get("properties", {}).items():
            target = definitions.get(spec.get("$ref", "").removeprefix("#/$defs/"), {})
            words = spec.get("description") or target.get("description") or ""
            if not words.partition("Default: ")[0]:
                keys_without_help.append(f"{name}.{key}")
    assert keys_without_help == []


def test_step_has_exactly_one_of_all_keys(procedure):
    step = procedure["$defs"]["Step"]
    assert set(step["properties"]) == set(installed_kinds().steps)
    assert (step["minProperties"], step["maxProperties"]) == (1, 1)
    assert step["additionalProperties"] is False
    assert procedure["properties"]["main"]["items"] == {"$ref": "#/$defs/Step"}
    assert procedure["$defs"]["SweepStep"]["properties"]["steps"]["items"] == {
        "$ref": "#/$defs/Step"
    }


def test_all_values_except_parameters_may_be_references(procedure):
    hampel = procedure["$defs"]["Hampel"]["properties"]["window"]
    assert "string" in hampel["type"]
    assert re.search(hampel["pattern"], "$window")
    assert not re.search(hampel["pattern"], "window")
    assert re.search(procedure["$defs"]["torque"]["pattern"], "$limit")
    assert "$[A-Za-z]" not in json.dumps(procedure["properties"]["parameters"])


def test_station_allows_no_references(shipped):
    pattern = language_schema("station", shipped)["$defs"]["torque"]["pattern"]
    assert not re.search(pattern, "$limit")


def test_measurand_of_a_limit_may_be_that_of_any_analysis(shipped):
    def keys(*analyses):
        plugins = [Plugin("analysis", record, Provider("lab", "1")) for record in analyses]
        others = [plugin for plugin in shipped.plugins if plugin.kind != "analysis"]
        schema = language_schema("procedure", Registry([*others, *plugins]))
        measurand = schema["$defs"]["Limit"]["properties"]["measurand"]
        assert measurand.pop("description").startswith("The quantity that the limit applies to")
        return measurand, schema["$defs"]

    without_model, _ = keys(analysis(model=None))
    assert without_model == {"type": "object", "additionalProperties": True}
    single, definitions = keys(analysis(), analysis("hardness_again"))
    assert single == {"$ref": "#/$defs/LimitOfHardness"}
    assert set(definitions["LimitOfHardness"]["properties"]) == {"scale", "load"}
    two, _ = keys(analysis(), analysis("colour", LimitOfColour))
    assert two["anyOf"] == [
        {"$ref": "#/$defs/LimitOfColour"},
        {"$ref": "#/$defs/LimitOfHardness"},
    ]


class Press(Settings):
    limit: Force
    """The highest force."""


class Straight(Settings):
    through_zero: bool = False


class ByAFit(Settings):
    """Settings that name a fit."""

    fit: FitRef | None = None


BY_A_FIT = AnalysisRecord(
    name="by_a_fit",
    help="By a fit",
    settings=ByAFit,
    factory=lambda _: None,
    yields=lambda _: (),
)


def registry_of(*records):
    kinds = {DeviceRecord: "device", FitRecord: "fit", AnalysisRecord: "analysis"}
    provider = Provider("a third party", "1")
    return Registry(Plugin(kinds[type(record)], record, provider) for record in records)


PRESS = DeviceRecord(name="press", help="A press", settings=Press, factory=lambda *_: None)
STRAIGHT = FitRecord(name="straight", help="A line", settings=Straight, factory=lambda _: None)


def test_third_party_fit_is_in_the_schema():
    definitions = language_schema("procedure", registry_of(STRAIGHT, BY_A_FIT))["$defs"]
    alternatives = definitions["FitRef"]["anyOf"]
    assert alternatives[0]["enum"] == ["straight"]
    assert alternatives[0]["enumDescriptions"] == ["A line"]
    assert alternatives[-1]["properties"]["straight"]["$ref"] == "#/$defs/Straight"
    assert "Default: false." in definitions["Straight"]["properties"]["through_zero"]["description"]


def test_third_party_device_is_in_the_schema():
    binding = language_schema("station", registry_of(PRESS))["$defs"]["DeviceBinding"]
    assert binding["properties"]["plugin"]["enum"] == ["press"]
    (rule,) = binding["allOf"]
    assert rule["if"]["properties"]["plugin"] == {"const": "press"}
    assert rule["then"] == {
        "properties": {"settings": {"$ref": "#/$defs/Press"}},
        "required": ["settings"],
    }


def test_plugin_with_required_settings_is_not_offered_by_name_alone():
    strict = FitRecord(name="strict", help="Strict", settings=Press, factory=lambda _: None)
    alternatives = language_schema("procedure", registry_of(strict, BY_A_FIT))["$defs"]["FitRef"][
        "anyOf"
    ]
    assert alternatives[0]["enum"] == []
    assert "strict" in alternatives[-1]["properties"]


def test_quantity_description_has_units_and_bounds(procedure):
    window = procedure["$defs"]["TemplateInverseSettings"]["properties"]["window"]
    assert window["$ref"] == "#/$defs/angle"
    assert window["description"].endswith(
        "Angle in rad or mrad or deg or arcmin or arcsec, more than 0. Default: 1 deg."
    )
    message = "expected a number with its unit: rad, mrad, deg, arcmin, arcsec"
    assert procedure["$defs"]["angle"]["errorMessage"] == message
