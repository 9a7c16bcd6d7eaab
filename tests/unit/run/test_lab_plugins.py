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
pytestmark = pytest.mark.usefixtures("tester")


def test_a_plugin_from_the_stations_folder_takes_part_and_is_on_record(tmp_path):
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
    assert_analysed_again_with_the_station_alone(finished.folder, station, tmp_path / "again.html")


def loaded(folder, *changes):
    return procedure_file(folder, "loaded", *changes)


def assert_analysed_again_with_the_station_alone(folder, station, report):
    for words in (["analyse", folder], ["report", folder, "--out", report]):
        without = call(*words)
        assert without.code == ExitCode.INVALID
        assert "there is no decision rule 'twice'" in without.err
        assert call(*words, "--station", station).code == ExitCode.PASS
    assert report.is_file()


def test_a_missing_plugin_folder_is_a_problem_of_the_station(tmp_path):
    station = station_file(tmp_path, ("id: bench\n", "id: bench\nplugins: nowhere\n"))
    with pytest.raises(InvalidFileError, match=r"station\.yaml:3:10: plugins: there is no plugin"):
        run(procedure_file(tmp_path, "idle"), tmp_path / "runs", station=station)
