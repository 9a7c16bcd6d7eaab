"""A lab's own outlier rule is used in the analysis of torque."""

from helpers_cli import call
from helpers_workflow import quick_procedure, run, station_file
from rigrunner.api.errors import ExitCode
from rigrunner.runfile import read
from rigrunner_bearings.api.torque import TorqueDetails

MEDIAN_RULE = """
from rigrunner.api.analysis import Rejection
from rigrunner.api.hooks import OutlierRuleRecord, hookimpl

api_version = 1


def first_one(values):
    return [Rejection(0, float(values[0]), "first_one", 1.0, 0.0)]


@hookimpl
def rigrunner_outlier_rules():
    return [
        OutlierRuleRecord(
            name="first_one", help="Rejects the first.", factory=lambda settings: first_one
        )
    ]
"""


def test_plugin_in_station_folder_is_used_and_recorded(tmp_path):
    (tmp_path / "my_plugins").mkdir()
    (tmp_path / "my_plugins" / "rule.py").write_text(MEDIAN_RULE)
    station = station_file(tmp_path, ("id: simulated\n", "id: simulated\nplugins: my_plugins\n"))
    procedure = quick_procedure(
        tmp_path, "no_load_inertia_sweep", ("{grubbs: {alpha: 0.05}}", "first_one")
    )
    finished = run(procedure, tmp_path / "runs", station=station)
    assert finished.error is None
    assert all(not point.peak_kept[0] for point in TorqueDetails.of(finished.result).loaded)
    assert "rule.py sha256:" in read(finished.folder).header.provenance["plugin providers"]
    assert_reanalysis_needs_station(finished.folder, station, tmp_path / "again.html")


def assert_reanalysis_needs_station(folder, station, report):
    for words in (["analyse", folder], ["report", folder, "--out", report]):
        output = call(*words)
        assert output.code == ExitCode.INVALID
        assert "there is no outlier rule 'first_one'" in output.err
        assert call(*words, "--station", station).code == ExitCode.PASS
    assert report.is_file()
