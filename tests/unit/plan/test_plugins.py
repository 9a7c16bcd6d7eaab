"""The plugins that files name exist and accept their settings."""

from __future__ import annotations

import pytest
from pydantic import create_model

from helpers_language import (
    PROCEDURE,
    STATION,
    Drive,
    Lookup,
    edited,
    only_problem,
    place_of,
    problems_of,
)
from rigrunner.api.settings import Length, Settings, WrapperSettings
from rigrunner.plan import check_plugins
from rigrunner.procedure import parse_procedure
from rigrunner.station import parse_station

AT = "analysis[0].swing_torque"


def checked(text, station=STATION):
    check_plugins(parse_procedure(text, "p.yaml"), parse_station(station, "s.yaml"), Lookup())


def test_valid_procedure_passes():
    checked(PROCEDURE)


@pytest.mark.parametrize(
    ("old", "new", "finger", "field", "message"),
    [
        ("{grubbs:", "{grubs:", "grubs", f"{AT}.outliers.grubs",
         "there is no outlier_rule 'grubs'"),
        ("- inertia", "- inretia", "inretia", f"{AT}.fits[1]", "there is no fit 'inretia'"),
        ("- energy", "- enrgy", "enrgy", f"{AT}.compensations[1]",
         "there is no compensation 'enrgy'"),
        ("alpha: 0.05", "alfa: 0.05", "alfa", f"{AT}.outliers.grubbs.alfa",
         "unknown key 'alfa'"),
        ("alpha: 0.05", "alpha: low", "low", f"{AT}.outliers.grubbs.alpha",
         "got 'low', expected a number"),
        ("degree: 2", "degree: 2.5", "2.5", f"{AT}.fits[0].polynomial.degree",
         "got 2.5, expected a whole number"),
        ("degree: 2", "degree: 2, powers: [0, x]", "x]", f"{AT}.fits[0].polynomial.powers[1]",
         "got 'x', expected a whole number"),
        ("polynomial: {degree: 2}", "polynomial", "polynomial",
         f"{AT}.fits[0].polynomial.degree", "the key 'degree' is missing"),
        ("polynomial: {degree: 2}", "polynomial:", "polynomial:",
         f"{AT}.fits[0].polynomial.degree", "the key 'degree' is missing"),
        ("rule: guard_band_u", "rule: guard_band", "guard_band\n", "acceptance.rule",
         "there is no decision_rule 'guard_band'"),
        ("rule: guard_band_u", "rule: guard_band\n  fraction: 1", "guard_band\n",
         "acceptance.rule", "there is no decision_rule 'guard_band'"),
        ("rule: guard_band_u", "rule: guard_band_fraction", "rule: guard_band_fraction",
         "acceptance.rule.guard_band_fraction.fraction", "the key 'fraction' is missing"),
        ("rule: guard_band_u", "rule: guard_band_u\n  fraction: 1.25", "1.25",
         "acceptance.fraction", "the rule 'guard_band_u' has no such setting"),
        ("rule: guard_band_u", "rule: {guard_band_fraction: {fraction: 9}}", "9}}",
         "acceptance.rule.guard_band_fraction.fraction", "got 9, expected 5.0 or less"),
    ],
)  # fmt: skip
def test_wrong_plugin_or_setting_in_a_procedure_is_refused(old, new, finger, field, message):
    text = edited(PROCEDURE, (old, new))
    problem = only_problem(checked, text)

    assert problem.message == message
    assert problem.field == field
    assert str(problem.location) == f"p.yaml:{place_of(text, finger)}"


@pytest.mark.parametrize(
    ("old", "new", "finger", "field", "message"),
    [
        ("plugin: fake", "plugin: fkae", "fkae", "devices.tester.plugin",
         "there is no device 'fkae'"),
        ("gain: 1 N·m", "gain: 1 N", "1 N}", "devices.tester.settings.gain",
         "'1 N' is a force, not a torque"),
        ("gain: 1 N·m", "gain: 1 N·m, quiet: on", "on}", "devices.tester.settings.quiet",
         "got 'on', expected yes or no"),
        ("    settings: {gain: 1 N·m}\n", "", "tester:", "devices.tester.settings.gain",
         "the key 'gain' is missing"),
    ],
)  # fmt: skip
def test_wrong_device_or_setting_in_a_station_is_refused(old, new, finger, field, message):
    station = edited(STATION, (old, new))
    problem = only_problem(checked, PROCEDURE, station)

    assert problem.message == message
    assert problem.field == field
    assert str(problem.location) == f"s.yaml:{place_of(station, finger)}"


@pytest.mark.parametrize(
    "case",
    [
        ("eccentric: 2 mm", "eccentric: 2", "2\n", "rig.eccentric",
         "2 is not a number with a unit", "write it as '2 m'"),
        ("eccentric: 2 mm", "eccentric: 0 mm", "0 mm", "rig.eccentric",
         "got '0 mm', expected more than 0", ""),
        ("eccentric: 2 mm", "eccentric: 50 mm", "mandrel", "rig",
         "eccentric must be less than centre_distance", ""),
        ("eccentric: 2 mm", "eccentric: 2 mm\n  excentric: 2 mm", "excentric", "rig.excentric",
         "unknown key 'excentric'", "did you mean 'eccentric'? known keys: mandrel, eccentric"),
        ("kg·m²", "kg·m", "0.00233", "rig.inertia", "is a quantity in kg·m", "kg·m²"),
    ],
)  # fmt: skip
def test_wrong_rig_key_is_refused(case):
    old, new, finger, field, message, hint = case
    station = edited(STATION, (old, new))
    problem = only_problem(checked, PROCEDURE, station)
    assert message in problem.message
    assert problem.field == field
    assert hint in problem.hint
    assert str(problem.location) == f"s.yaml:{place_of(station, finger)}"


class Oven(Settings):
    volume: Length
    """A key that must be there where its plugin is used."""
    mandrel: str = ""


class OvenLookup(Lookup):
    """Plugins of two domains, of which one compensation and one fit declare keys of a rig."""

    def rig_model(self):
        return create_model("Rig", __base__=(Oven, Drive))

    def rig_of(self, kind, name):
        return Oven if name == "inertia" else super().rig_of(kind, name)


def test_rig_key_of_an_unused_plugin_is_optional():
    text = edited(PROCEDURE, ("        - inertia\n", ""))
    check_plugins(parse_procedure(text, "p.yaml"), parse_station(STATION, "s.yaml"), OvenLookup())


def test_rig_key_of_a_used_plugin_is_required():
    problem = only_problem(
        check_plugins, parse_procedure(PROCEDURE, "p.yaml"), parse_station(STATION, "s.yaml"),
        OvenLookup(),
    )  # fmt: skip
    assert (problem.field, problem.message) == ("rig.volume", "the key 'volume' is missing")
    at = place_of(PROCEDURE, "inertia\n")
    assert problem.hint == f"the fit 'inertia' needs it (p.yaml:{at})"
    assert str(problem.location) == f"s.yaml:{place_of(STATION, 'rig:')}"


def test_rig_key_of_a_wrapped_device_is_required():
    class OfFake(OvenLookup):
        def rig_of(self, kind, name):
            return Oven if (kind, name) == ("device", "fake") else None

    lookup = OfFake()
    lookup.known["device", "wrapper"] = WrapperSettings
    station = edited(
        STATION,
        ("plugin: fake", "plugin: wrapper"),
        ("settings: {gain: 1 N·m}", "settings: {plugin: fake, settings: {gain: 1 N·m}}"),
    )
    problem = only_problem(
        check_plugins,
        parse_procedure(PROCEDURE, "p.yaml"),
        parse_station(station, "s.yaml"),
        lookup,
    )
    assert problem.message == "the key 'volume' is missing"
    assert problem.hint == f"the device 'fake' needs it (s.yaml:{place_of(station, 'fake,')})"


def test_problem_in_a_referenced_setting_names_both_places():
    text = edited(PROCEDURE, ("degree: 2", "degree: $load"))
    problem = only_problem(checked, text)

    place = place_of(text, "$load}\n        - i")
    assert str(problem.location) == f"p.yaml:{place}"
    assert problem.hint == f"it is written at p.yaml:{place_of(text, '1000 N')}"


def test_problems_of_both_files_are_reported_together():
    text = edited(PROCEDURE, ("alpha: 0.05", "alpha: low"), ("degree: 2", "degree: x"))
    station = edited(STATION, ("gain: 1 N·m", "gain: 1"))

    assert [problem.location.file for problem in problems_of(checked, text, station)] == [
        "p.yaml",
        "p.yaml",
        "s.yaml",
    ]
