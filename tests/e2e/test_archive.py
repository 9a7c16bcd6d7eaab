"""The commands of the archive as a person uses them, including mistakes."""

from __future__ import annotations

import csv
import io
import json
import re
import shutil
from contextlib import closing

import pytest

from helpers_cli import call
from rigrunner_fleet.archive import index, open_archive
from unit.rigrunner_fleet.archive.helpers_archive import result_document, store_run


@pytest.fixture(scope="module")
def archived_runs(tmp_path_factory):
    """Two runs and their archive; treat the folder as read-only."""
    folder = tmp_path_factory.mktemp("made") / "runs"
    store_run(folder, "one", inputs={"specimen": "SN-1", "lot": "L1"})
    fail = result_document(0.96, "fail")
    store_run(folder, "two", fail, inputs={"specimen": "SN-\x1b[31m"})
    with closing(open_archive(folder)) as archive:
        index(archive, [folder])
    return folder


@pytest.fixture
def indexed(archived_runs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(archived_runs, tmp_path / "runs")
    return tmp_path / "runs"


@pytest.fixture
def runs(indexed):
    (indexed / ".rigrunner-archive.sqlite").unlink()
    return indexed


def test_index_reports_what_it_found(runs):
    (runs / "bad").mkdir()
    (runs / "bad" / "run.h5").write_text("no")
    done = call("archive", "index", "runs")
    assert (done.code, done.out) == (0, "")
    assert "runs: 3 runs, 3 new, 0 updated." in done.err
    assert "Unreadable: 1\n  bad: " in done.err
    shutil.rmtree(runs / "one")
    assert "Gone since they were indexed: 1\n  one" in call("archive", "index").err


@pytest.mark.usefixtures("indexed")
def test_search_prints_a_table():
    done = call("archive", "search")
    assert done.code == 0
    assert re.search(
        r"^one +SN-1 +simulated +completed +pass +0.720 ± 0.010$", done.out, re.MULTILINE
    )
    assert "\x1b" not in done.out, "no specimen controls the terminal"
    assert done.err == "2 runs\n"
    assert call("archive", "search", "--specimen", "X*").err == "No matching runs.\n"


@pytest.mark.usefixtures("indexed")
def test_search_as_json_and_csv_has_every_column():
    (row,) = json.loads(call("archive", "search", "--verdict", "pass", "--json").out)
    assert (row["run_id"], row["torque_nm"], row["dof"]) == ("one", 0.72, "infinite")
    assert row["started_utc"] == "2026-03-01T12:00:00.000Z"
    (line,) = csv.DictReader(io.StringIO(call("archive", "search", "--lot", "L1", "--csv").out))
    assert set(line) == set(row)
    assert (line["run_id"], line["torque_nm"]) == ("one", "0.72")


@pytest.mark.usefixtures("indexed")
@pytest.mark.parametrize(
    ("options", "found"),
    [
        (["--torque", "0.9..1 N·m"], ["two"]),
        (["--frequency", "10 Hz", "--torque", "..0.75 N·m"], ["one"]),
        (["--frequency", "11 Hz"], []),
        (["--figure", "inertia=0.002..0.003 kg·m²", "--verdict", "fail"], ["two"]),
        (["--input", "lot=L?"], ["one"]),
        (["--specimen", "SN-1", "--specimen", "none"], ["one"]),
        (["--limit", "1"], ["two"]),
        (["--since", "2026-03-02"], []),
        (["--load", "990..1010 N", "--raw-peak", "3..3 N·m"], ["one", "two"]),
        (["--real"], ["one", "two"]),
    ],
)
def test_options_narrow_a_search(options, found):
    rows = json.loads(call("archive", "search", "--json", *options).out)
    assert [row["run_id"] for row in rows] == found


@pytest.mark.usefixtures("indexed")
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["search", "--runs", "nowhere"], "there is no archive"),
        (["search", "--torque", "0.5..0.8"], "has no unit"),
        (["search", "--torque", "0.5 N·m"], "is not a range"),
        (["search", "--verdict", "passed"], "conditional pass"),
        (["search", "--since", "last week"], "such as 2026-01-31"),
        (["search", "--input", "lot"], "such as --input order=A-17"),
        (["search", "--figure", "inertia"], "such as --figure"),
        (["search", "--figure", "a=..1 N", "--figure", "a=1 N.."], "is given twice"),
        (["search", "--json", "--csv"], "exclude each other"),
        (["search", "--database", "mysql://user:secret@host/db"], "not a database for archives"),
        (["search", "--database", "postgresql://host:port/lab"], "not a valid address"),
        (["search", "--limit", "0"], "--limit"),
        (["serch"], "Did you mean 'search'"),
        (["index", "nowhere"], "there is no folder nowhere"),
        (["index", "runs/one"], "is a run"),
        (["index", "runs", "other"], "several folders need one database"),
        (["export", "point", "a.csv"], "there are: runs, points"),
        (["export", "points", "a.xlsx"], "ends with .csv or .parquet"),
    ],
)
def test_mistake_exits_with_2_and_a_hint(arguments, says):
    done = call("archive", *arguments)
    assert done.code == 2, done.err
    assert says in done.err
    assert "secret" not in done.err
    assert "Traceback" not in done.err


@pytest.mark.usefixtures("indexed")
def test_unreachable_server_is_reported_without_its_password():
    place = "postgresql://ann:secret@127.0.0.1:1/lab"
    done = call("archive", "search", "--database", place)
    assert done.code == 5
    assert "ann:***@127.0.0.1" in done.err
    assert "secret" not in done.err


def test_export_writes_a_file(indexed):
    assert "Wrote points.csv: 4 rows." in call("archive", "export", "points", "points.csv").err
    with (indexed.parent / "points.csv").open(newline="") as file:
        assert [row["set_frequency_hz"] for row in csv.DictReader(file)] == ["10.0", "20.0"] * 2
    done = call("archive", "export", "points", "ten.parquet", "--frequency", "10 Hz")
    assert "2 rows" in done.err


def test_export_has_formulas_only_with_raw(indexed):
    store_run(indexed, "three", inputs={"specimen": "=1+1"})
    assert call("archive", "index", "runs").code == 0
    for raw, shown in (([], "'=1+1"), (["--raw"], "=1+1")):
        assert call("archive", "export", "runs", "runs.csv", *raw).code == 0
        with (indexed.parent / "runs.csv").open(newline="") as file:
            assert [row["specimen"] for row in csv.DictReader(file)][-1] == shown
        searched = call("archive", "search", "--csv", *raw).out
        assert [row["specimen"] for row in csv.DictReader(io.StringIO(searched))][-1] == shown


@pytest.mark.thorough
def test_several_folders_in_one_database_and_rebuild(indexed):
    store_run(indexed.parent / "other", "three")
    database = ["--database", "lab.sqlite"]
    assert call("archive", "index", "runs", "other", *database).code == 0
    shutil.rmtree(indexed.parent / "other" / "three")
    done = call("archive", "rebuild", *database)
    assert done.code == 0
    assert "other: 0 runs" in done.err
    rows = json.loads(call("archive", "search", "--json", *database).out)
    assert [row["run_id"] for row in rows] == ["one", "two"]


def test_environment_variable_sets_the_database(indexed, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_DATABASE", str(indexed.parent / "mine.sqlite"))
    assert "mine.sqlite" in call("archive", "search").err
    assert call("archive", "index").code == 0
    assert (indexed.parent / "mine.sqlite").exists()
