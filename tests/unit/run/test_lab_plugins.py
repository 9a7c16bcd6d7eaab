import re

import pytest

from helpers_cli import call
from helpers_tester import PER_1000_N, procedure_file, run, station_file
from rigrunner.api.errors import ExitCode, InvalidFileError
from rigrunner.runfile import read

RULE = """
from rigrunner.api import Verdict, Zone
from rigrunner.api.hooks import DecisionRuleRecord, hookimpl

api_version = 1


class Twice:
    words = {"en": "passes to twice the limit"}

    def __call__(self, limits, estimate):
        return [Zone(Verdict.PASS, -limits.upper)]


@hookimpl
def rigrunner_decision_rules():
    return [
        DecisionRuleRecord(
            name="twice", help="Passes.", factory=lambda settings: Twice(), passes_outside=True
        )
    ]
"""
SIDES = """
from dataclasses import dataclass
from typing import Literal

from rigrunner.api import (
    AnalysisRecord, Component, Estimate, Findings, MeasurementResult, ResultDefinition, Settings,
    hookimpl,
)

api_version = 1


@dataclass(frozen=True)
class Side:
    side: str

    @property
    def id(self):
        return f"torque.{self.side}"

    def __str__(self):
        return f"torque of the {self.side} side"


class LimitOfSide(Settings):
    side: Literal["left", "right"]

    def __str__(self):
        return str(Side(self.side))

    def objection(self, found):
        return "" if found == Side(self.side) else f"it is the {found}, not the {self}"

    def as_written(self):
        return {"side": self.side}

    def document(self):
        return {"side": self.side, "text": str(self)}


LEFT = ResultDefinition(name="side_torque", unit="N·m", measurand=Side("left"))


def of_left_side(run):
    noise = Component("noise", 0.01, 9.0, "normal", common=False)
    result = MeasurementResult(of=LEFT, estimate=Estimate(0.5, 0.01, 9.0), components=(noise,))
    return Findings(results=(result,))


@hookimpl
def rigrunner_analyses():
    return [
        AnalysisRecord(
            name="sides",
            help="Torque of the left side.",
            factory=lambda settings: of_left_side,
            yields=lambda settings: (LEFT,),
            limit_measurand=LimitOfSide,
        )
    ]
"""
pytestmark = pytest.mark.usefixtures("tester")


def test_plugin_from_folder_of_station_is_used_and_recorded(tmp_path):
    (tmp_path / "my_plugins").mkdir()
    (tmp_path / "my_plugins" / "rule.py").write_text(RULE)
    station = station_file(tmp_path, ("id: bench\n", "id: bench\nplugins: my_plugins\n"))
    run(procedure_file(tmp_path, "idle"), tmp_path / "runs", station=station)
    strict = ("max: 0.95 N·m", f"max: {0.9 * PER_1000_N} N·m")
    assert (
        run(loaded(tmp_path, strict), tmp_path / "runs", station=station).exit_code == ExitCode.FAIL
    )
    changes = strict, ("rule: guard_band_u", "rule: twice")
    finished = run(loaded(tmp_path, *changes), tmp_path / "runs", station=station)
    assert finished.error is None
    assert finished.exit_code == ExitCode.PASS
    assert "rule.py sha256:" in read(finished.folder).header.provenance["plugin providers"]
    assert_reanalysis_needs_the_station(finished.folder, station, tmp_path / "again.html")


def loaded(folder, *changes):
    return procedure_file(folder, "loaded", *changes)


def assert_reanalysis_needs_the_station(folder, station, report):
    for words in (["analyse", folder], ["report", folder, "--out", report]):
        result = call(*words)
        assert result.code == ExitCode.INVALID
        assert "there is no decision rule 'twice'" in result.err
        assert call(*words, "--station", station).code == ExitCode.PASS
    assert report.is_file()


def sides(folder, measurand, name="sides.yaml"):
    """Write `idle` with a limit of the left side's torque."""
    path = procedure_file(folder, "idle").rename(folder / name)
    text = path.read_text(encoding="utf-8")
    path.write_text(
        f"{text[: text.index('analysis:')]}analysis:\n  - sides:\n{limits(measurand)}",
        encoding="utf-8",
    )
    return path


def limits(measurand, at_most="1 N·m"):
    return (
        f"acceptance:\n  limits:\n    - {{of: side_torque, max: {at_most}, source: a test,\n"
        f"       measurand: {{{measurand}}}}}\n"
    )


def test_analysis_of_station_can_define_its_measurand(tmp_path):
    (tmp_path / "my_plugins").mkdir()
    (tmp_path / "my_plugins" / "sides.py").write_text(SIDES, encoding="utf-8")
    station = station_file(tmp_path, ("id: bench\n", "id: bench\nplugins: my_plugins\n"))
    for wrong, message in (
        ("side: top", ".measurand.side: got 'top', expected 'left' or 'right'"),
        ("side: right", ".measurand: it is the torque of the left side, not the torque of the"),
    ):
        with pytest.raises(InvalidFileError) as caught:
            run(sides(tmp_path, wrong), tmp_path / "runs", station=station)
        (problem,) = caught.value.problems
        assert f"acceptance.limits[0]{message}" in f"{problem.field}: {problem.message}"
    finished = run(sides(tmp_path, "side: left"), tmp_path / "runs", station=station)
    assert finished.error is None
    assert finished.exit_code == ExitCode.PASS
    decision = read(finished.folder).result_document["decision"]
    assert decision["measurand"] == {"side": "left", "text": "torque of the left side"}
    assert call("verify", finished.folder, "--station", station).code == ExitCode.PASS
    decide_again(finished.folder, station)


def decide_again(folder, station):
    """Decide again by a lower limit, of the other side and of this one, and by another rule."""
    file = folder.parent / "acceptance.yaml"
    words = "decide", folder, "--station", station, "--by", "A. Person", "--reason", "a test"
    for side, code in (("right", ExitCode.DATA), ("left", ExitCode.FAIL)):
        text = f"rigrunner: acceptance/1\n{limits(f'side: {side}', '0.4 N·m')}"
        file.write_text(text, encoding="utf-8")
        assert call(*words, "--acceptance", file).code == code
    assert call(*words, "--rule", "guard_band_u").code == ExitCode.FAIL
    other_measurand = f"rigrunner: acceptance/1\n{limits('nature: no_load')}"
    file.write_text(other_measurand, encoding="utf-8")
    assert "measurand.side: the key 'side' is missing" in call(*words, "--acceptance", file).err
    file.write_text(re.sub(r",\s+measurand: {.*?}", "", other_measurand), encoding="utf-8")
    errors = call(*words, "--acceptance", file).err
    assert "the key 'measurand' is missing" in errors
    assert "nature" not in errors  # a key of an analysis that the procedure does not use


def test_missing_plugin_folder_is_a_problem_of_the_station(tmp_path):
    station = station_file(tmp_path, ("id: bench\n", "id: bench\nplugins: nowhere\n"))
    with pytest.raises(InvalidFileError, match=r"station\.yaml:3:10: plugins: there is no plugin"):
        run(procedure_file(tmp_path, "idle"), tmp_path / "runs", station=station)
