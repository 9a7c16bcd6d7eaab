import pytest

from rigrunner.api.errors import UsageError
from rigrunner.run.locate import (
    find_procedure,
    find_run,
    find_station,
    run_names,
    shipped_folder,
    station_names,
)


def test_shipped_files_are_found_by_name():
    assert find_procedure("starting_torque_1000n").parent == shipped_folder()
    assert find_station("simulated").name == "simulated.yaml"


def test_path_takes_precedence_over_shipped_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "simulated").write_text("mine")
    assert find_station("simulated").read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("starting_torque_100n", "did you mean 'starting_torque_1000n'"),
        ("zzz", "there are: friction_endurance, gauge_rr, loaded_breakaway"),
        ("sub/starting_torque_1000n", "there is no procedure"),
    ],
)
def test_unknown_procedure_error_suggests_names(name, words):
    with pytest.raises(UsageError, match=words):
        find_procedure(name)


def test_folder_is_not_a_procedure(tmp_path):
    with pytest.raises(UsageError, match="is a folder, not a procedure file"):
        find_procedure(str(tmp_path))


@pytest.fixture
def runs(tmp_path):
    for name in ("20260102T000000Z_B_x", "20260101T000000Z_A_x", "20260101T000000Z_A_y", ".trash"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "run.h5").touch()
    return tmp_path


def test_only_newest_of_many_runs_are_suggested(tmp_path):
    names = [f"2026{month:02}{day:02}T000000Z_A" for month in (1, 2) for day in range(1, 29)]
    for name in names:
        (tmp_path / name).mkdir()
    with pytest.raises(UsageError) as caught:
        find_run("qqq", tmp_path)
    assert str(caught.value.hint).endswith(f"{names[-1]}, the last 12 of 56")
    assert names[-13] not in str(caught.value.hint)
    with pytest.raises(UsageError, match=r"could be any of: 20260117T.*, the last 12 of 28$"):
        find_run("202601", tmp_path)


def test_runs_are_listed_oldest_first_without_hidden_folders(runs):
    assert [name[:8] for name in run_names(runs)] == ["20260101", "20260101", "20260102"]
    assert run_names(runs / "nowhere") == []


def test_run_is_found_by_path_file_name_and_unique_prefix(runs):
    folder = runs / "20260102T000000Z_B_x"
    assert find_run(str(folder), runs) == folder
    assert find_run(str(folder / "run.h5"), runs) == folder
    assert find_run(folder.name, runs) == folder
    assert find_run("20260102", runs) == folder


def test_ambiguous_or_unknown_run_error_suggests_runs(runs):
    with pytest.raises(UsageError, match="could be any of: 20260101T000000Z_A_x, "):
        find_run("20260101", runs)
    with pytest.raises(UsageError, match="did you mean '20260102T000000Z_B_x'"):
        find_run("20260102T00000Z_B_x", runs)


@pytest.mark.parametrize(
    ("path", "hint"),
    [
        ("stations.yaml", "did you mean 'station.yaml'?"),
        ("lab/statoin.yaml", "did you mean 'lab/station.yaml'?"),
        ("station", "did you mean 'station.yaml'?"),
        ("station.yml", "did you mean 'station.yaml'?"),
        ("nosuch.yaml", f"there are: {', '.join(station_names())}"),
        ("lap/station.yaml", "there is no folder lap"),
        ("simulatd", "did you mean 'simulated'?"),
        ("lab", "YAML files in it: station.yaml"),
    ],
)
def test_mistyped_file_error_suggests_files_of_its_folder(tmp_path, monkeypatch, path, hint):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for folder in (tmp_path, tmp_path / "lab"):
        (folder / "station.yaml").touch()
    with pytest.raises(UsageError) as caught:
        find_station(path)
    assert caught.value.hint.replace("\\", "/") == hint


def test_procedure_file_is_not_a_run(tmp_path):
    procedure = tmp_path / "diode.yaml"
    procedure.write_text("rigrunner: procedure/2\n", encoding="utf-8")
    with pytest.raises(UsageError, match="is not a run") as caught:
        find_run(str(procedure), tmp_path)
    assert "a run is its folder" in caught.value.hint
