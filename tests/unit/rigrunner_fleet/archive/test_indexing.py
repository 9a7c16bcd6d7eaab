"""Indexing runs into an archive, on both engines."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from contextlib import closing, suppress
from datetime import UTC, datetime
from math import inf

import h5py
import numpy as np
import pytest

from helpers_thorough import first
from rigrunner.api.errors import DataError, UsageError
from rigrunner.jobs import Processes
from rigrunner.jobs.done import Answer, Done
from rigrunner_fleet.archive import index, open_archive, query, rebuild
from unit.rigrunner_fleet.archive.helpers_archive import result_document, store_run
from unit.runfile.helpers_runfile import TWO, write_run


@pytest.fixture
def archive(database):
    with closing(open_archive(database=database)) as opened:
        yield opened


def rows_of(archive, table="runs", **filters):
    return list(query(table, database=str(archive.file or archive.location), **filters))


def test_row_of_a_run_has_its_metadata_and_result(archive, runs):
    inputs = {"specimen": "SN-1", "type": "GE20", "lot": "L7", "operator": "Zoë", "order": "A"}
    folder = store_run(runs, "one", inputs=inputs, people={"operator": "Zoë"})
    (indexed,) = index(archive, [runs])
    assert (indexed.runs, indexed.new, indexed.changed) == (1, 1, 0)
    assert (indexed.unreadable, indexed.missing) == ((), ())
    (row,) = rows_of(archive)
    assert row["folder"] == str(folder)
    assert row["started_utc"] == datetime(2026, 3, 1, 12, tzinfo=UTC)
    expected = {
        "run_id": "one", "procedure": "SSPB-STT-1000", "revision": "A", "rig": "simulated",
        "specimen": "SN-1", "type": "GE20", "lot": "L7", "operator": "Zoë", "mandrel": "M-01",
        "outcome": "completed", "sealed": True, "recordings": 1, "method": "template_inverse",
        "torque_nm": 0.72, "u_nm": 0.005, "expanded_nm": 0.01, "dof": inf, "raw_peak_nm": 3.7,
        "verdict": "pass", "failed_checks": 2, "approval": "draft", "simulated": False,
        "no_load_run": "no-load", "problem": "", "missing": False,
    }  # fmt: skip
    assert {name: row[name] for name in expected} == expected
    with h5py.File(folder / "run.h5") as file:
        manifest = file["entry/manifest"][()].tobytes()
        assert row["digest_sha256"] == file["entry"].attrs["sha256"]
    assert row["manifest_sha256"] == hashlib.sha256(manifest).hexdigest()
    assert row["bytes"] == (folder / "run.h5").stat().st_size


def test_points_figures_inputs_and_files_have_tables(archive, runs):
    folder = store_run(runs, "one", inputs={"specimen": "SN-1"})
    (folder / "note.txt").write_text("seen\n")
    index(archive, [runs])
    points = rows_of(archive, "points")
    assert [point["set_frequency_hz"] for point in points] == [10.0, 20.0]
    assert [point["torque_nm"] for point in points] == pytest.approx([0.73, 0.74])
    assert [point["raw_peak_nm"] for point in points] == [3.0, 4.0]
    assert [point["number"] for point in points] == [1, 2]
    assert {point["run_id"] for point in points} == {"one"}
    figures = {
        (figure["source"], figure["name"]): (figure["value"], figure["unit"])
        for figure in rows_of(archive, "figures")
    }
    assert figures == {
        ("template_inverse", "inertia"): (0.00232, "kg·m²"),
        ("fit polynomial", "c0"): (0.9, "N·m"),
        ("zero", "tester.torque"): (0.0123, "N·m"),
    }
    assert [(row["name"], row["value"]) for row in rows_of(archive, "inputs")] == [
        ("specimen", "SN-1")
    ]
    files = {file["name"]: file["sha256"] for file in rows_of(archive, "files")}
    assert files == {"run.h5": "", "note.txt": hashlib.sha256(b"seen\n").hexdigest()}


def test_only_new_or_changed_runs_are_read_again(archive, runs):
    first, second = store_run(runs), store_run(runs)
    index(archive, [runs])
    (unchanged,) = index(archive, [runs])
    assert (unchanged.runs, unchanged.new, unchanged.changed) == (2, 0, 0)
    (first / "report.html").write_text("<p>")
    (indexed,) = index(archive, [runs])
    assert (indexed.new, indexed.changed) == (0, 1)
    stat = (second / "run.h5").stat()
    os.utime(second / "run.h5", ns=(stat.st_atime_ns, stat.st_mtime_ns + 1))
    assert index(archive, [runs])[0].changed == 1


def test_latest_decision_gives_the_verdict(archive, quick, tmp_path):
    from rigrunner.cli.main import main  # noqa: PLC0415  (heavy, for this test alone)

    folder = tmp_path / "decided" / quick.loaded.name
    shutil.copytree(quick.loaded, folder)
    limits = tmp_path / "limits.yaml"
    limits.write_text(
        "rigrunner: acceptance/1\nacceptance:\n  limits:\n  - of: torque\n    mean: yes\n"
        "    max: 0.6 N·m\n    source: a drawing\n"
        "    measurand: {nature: load_induced, condition: at_reversal, load: 1000 N}\n"
        "  rule: simple\n"
    )
    command = ["decide", str(folder), "--acceptance", str(limits), "--by", "Ann", "--reason", "new"]
    assert main(command) == 1
    index(archive, [folder.parent])
    (row,) = rows_of(archive)
    assert (row["verdict"], row["simulated"]) == ("fail", True)
    first, second = rows_of(archive, "decisions")
    assert (first["file"], first["verdict"], first["in_force"]) == ("run.h5", "pass", False)
    assert (second["file"], second["verdict"], second["in_force"]) == (
        "decision-2.json",
        "fail",
        True,
    )
    assert (second["by"], second["why"]) == ("Ann", "new")


def test_rows_equal_the_result_of_a_real_run(archive, demo):
    index(archive, [demo.folder])
    (row,) = rows_of(archive, specimen="DEMO-0001")
    document = json.loads((demo.loaded / "result.json").read_text())
    headline = document["headline"]["compensated"]
    assert row["torque_nm"] == headline["value"]
    assert row["expanded_nm"] == headline["expanded_uncertainty_95"]
    assert row["verdict"] == document["decision"]["verdict"]
    points = rows_of(archive, "points", specimen="DEMO-0001")
    compensated = document["compensations"]["template_inverse"]["points"]
    torques = [point["torque"]["value"] for point in compensated]
    assert [point["torque_nm"] for point in points] == torques
    raw = [point["raw_peak"]["mean"]["value"] for point in document["points"]]
    assert [point["raw_peak_nm"] for point in points] == raw
    (inertia,) = (
        figure
        for figure in rows_of(archive, "figures", specimen="DEMO-0001")
        if (figure["source"], figure["name"]) == ("template_inverse", "inertia")
    )
    parameter = document["compensations"]["template_inverse"]["parameters"]["inertia"]
    assert inertia["value"] == parameter["value"]
    assert inertia["u"] == parameter["standard_uncertainty"]


def test_damaged_files_are_listed_and_others_indexed(archive, runs):
    good, bad = store_run(runs, "good"), store_run(runs, "bad")
    index(archive, [runs])
    content = bytearray((bad / "run.h5").read_bytes())
    (bad / "run.h5").chmod(0o644)
    (bad / "run.h5").write_bytes(content[: len(content) // 2])
    (worse := runs / "worse").mkdir()
    (worse / "run.h5").write_bytes(b"nothing")
    (indexed,) = index(archive, [runs])
    assert [path for path, _ in indexed.unreadable] == ["bad", "worse"]
    rows = {row["path"]: row for row in rows_of(archive)}
    assert rows["good"]["problem"] == ""
    assert "truncated or damaged" in rows["bad"]["problem"]
    assert rows["bad"]["specimen"] == rows["good"]["specimen"], "its earlier row is kept"
    assert rows["worse"]["specimen"] is None
    assert rows["good"]["folder"] == str(good)


class DyingWorkers:
    """Workers of which one dies while it reads a file."""

    def outcomes(self, task, items, stop):
        assert not stop.is_set()
        for number, item in enumerate(items):
            died = item.path == "deadly"
            answer = (
                Answer(None, "the process was ended by SIGSEGV") if died else Answer(task(item))
            )
            yield Done(number, item, answer)


def test_file_that_kills_its_worker_is_unreadable(archive, runs):
    store_run(runs, "deadly")
    store_run(runs, "good")
    (indexed,) = index(archive, [runs], workers=DyingWorkers())
    assert indexed.unreadable == (("deadly", "the process was ended by SIGSEGV"),)
    assert [row["problem"] for row in rows_of(archive)] == ["the process was ended by SIGSEGV", ""]
    (again,) = index(archive, [runs])
    assert (again.new, again.changed, again.unreadable) == (0, 1, ()), "it may have been killed"
    assert [row["problem"] for row in rows_of(archive)] == ["", ""]


@pytest.mark.parametrize("database", first(1, ["sqlite", "postgresql"]), indirect=True)
def test_worker_processes_give_the_same_rows(archive, runs):
    for name in ("one", "two", "three"):
        store_run(runs, name, inputs={"specimen": name})
    counts = []
    index(archive, [runs], workers=Processes(2), progress=lambda *count: counts.append(count))
    assert (counts[0], counts[-1]) == ((0, 3), (3, 3))
    tables = ("runs", "points", "figures", "inputs", "files")
    parallel = {table: rows_of(archive, table) for table in tables}
    rebuild(archive, [runs])
    for table, rows in parallel.items():
        assert by_name(rows_of(archive, table)) == by_name(rows)


def by_name(rows):
    return sorted(rows, key=lambda row: (row["run_id"], str(row)))


def test_external_links_are_refused(archive, runs):
    folder = store_run(runs, "one")
    (folder / "run.h5").chmod(0o644)
    with h5py.File(folder / "run.h5", "r+") as file:
        del file["entry/inputs"]
        file["entry/inputs"] = h5py.ExternalLink("/etc/passwd", "/")
    index(archive, [runs])
    assert "is a link" in rows_of(archive)[0]["problem"]


@pytest.mark.parametrize(
    "document",
    [
        {"headline": {"compensated": {"value": "0.7", "standard_uncertainty": True}}},
        {"headline": None, "points": {}, "compensations": [], "fits": 3, "decision": "pass"},
        {"headline": {"compensated": {"value": 10**400}}, "points": [1, None, []]},
        {"points": [{"raw_peak": {"cycles_kept": 1 << 80}}], "compensations": {"a": None}},
    ],
)
def test_malformed_results_give_unknown_numbers(archive, runs, document):
    store_run(runs, "odd", document)
    (indexed,) = index(archive, [runs])
    assert indexed.unreadable == ()
    (row,) = rows_of(archive)
    assert (row["torque_nm"], row["u_nm"]) == (None, None)


def test_non_finite_results_are_unknown(archive, runs):
    document = result_document(float("nan"))
    store_run(runs, "nan", document)
    store_run(runs, "inf", result_document(float("inf")))
    index(archive, [runs])
    assert [row["torque_nm"] for row in rows_of(archive)] == [None, None]
    assert rows_of(archive, torque="-1..1 N·m") == []


def test_odd_names_are_stored_unchanged(archive, runs):
    odd = "O'Brien\"; DROP TABLE runs; -- %_ \N{GREEK SMALL LETTER MU} \u202e[a-z]"
    store_run(runs, "one", inputs={"specimen": odd, odd: odd})
    index(archive, [runs])
    (row,) = rows_of(archive, specimen=odd)
    assert row["specimen"] == odd
    assert [row["name"] for row in rows_of(archive, "inputs", inputs={odd: odd})] == [
        odd,
        "specimen",
    ]


def test_characters_that_databases_refuse_are_escaped(archive, runs):
    measurand = {"name": "\udc80", "symbol": "T"}
    store_run(runs, "one", result_document(measurand=measurand), inputs={"specimen": "a\0b"})
    index(archive, [runs])
    (row,) = rows_of(archive)
    assert (row["specimen"], row["measurand"]) == ("a\\x00b", "\\udc80")


def test_texts_too_long_for_an_index_are_shortened(archive, runs):
    rng = np.random.default_rng(1)
    long = "".join(chr(code) for code in rng.integers(0x4E00, 0x9FFF, 10_000))
    store_run(runs, "one", inputs={"specimen": long, long: long, "lot": "short"})
    (indexed,) = index(archive, [runs])
    assert indexed.unreadable == ()
    (row,) = rows_of(archive)
    assert row["specimen"] == f"{long[:599]}…"
    assert [row["value"] for row in rows_of(archive, "inputs")][-1] == long
    assert len(rows_of(archive, lot="short")) == 1


def test_path_too_long_for_an_index_is_reported(archive, runs):
    store_run(runs / ("a" * 250) / ("b" * 250) / ("c" * 200), "deep")
    store_run(runs, "good")
    (indexed,) = index(archive, [runs])
    ((path, problem),) = indexed.unreadable
    assert path.endswith("/deep")
    assert "too long" in problem
    assert [row["run_id"] for row in rows_of(archive)] == ["good"]


def test_far_future_times_and_pipes_do_not_stop_indexing(archive, runs):
    folder = store_run(runs, "one")
    (folder / "note.txt").write_text("x")
    with suppress(OSError, OverflowError):  # not every file system has such times
        os.utime(folder / "note.txt", times=(0, 10**10))
    (runs / "pipe").mkdir()
    os.mkfifo(runs / "pipe" / "run.h5")
    (indexed,) = index(archive, [runs])
    assert [path for path, _ in indexed.unreadable] == ["pipe"]
    assert "not a regular file" in indexed.unreadable[0][1]


def test_unsealed_runs_are_always_read_again(archive, runs):
    (runs / "open").mkdir()
    write_run(runs / "open", TWO)
    index(archive, [runs])
    (row,) = rows_of(archive)
    assert (row["sealed"], row["recordings"], row["torque_nm"]) == (False, 2, None)
    assert index(archive, [runs])[0].changed == 1


def test_hidden_folders_and_links_are_not_searched(archive, runs):
    store_run(runs / "2026" / "rig-1", "deep")
    store_run(runs / ".hidden", "hidden")
    (runs / "link").symlink_to(runs / "2026")
    (indexed,) = index(archive, [runs])
    assert indexed.runs == 1
    assert rows_of(archive)[0]["path"] == "2026/rig-1/deep"


def test_deleted_runs_are_kept_and_marked_missing(archive, runs):
    folder = store_run(runs, "gone")
    store_run(runs, "here")
    index(archive, [runs])
    shutil.rmtree(folder)
    for _ in range(2):
        (indexed,) = index(archive, [runs])
        assert indexed.missing == ("gone",)
    assert {row["run_id"]: row["missing"] for row in rows_of(archive)} == {
        "gone": True,
        "here": False,
    }


def test_moved_run_is_not_missing(archive, runs):
    folder = store_run(runs, "one")
    index(archive, [runs])
    (runs / "2026").mkdir()
    folder.rename(runs / "2026" / "one")
    (indexed,) = index(archive, [runs])
    assert indexed.missing == ()
    assert [row["path"] for row in rows_of(archive, copies=True)] == ["2026/one"]


def test_copies_of_a_run_count_once(archive, runs):
    folder = store_run(runs, "one")
    shutil.copytree(folder, runs / "copies" / "one")
    index(archive, [runs])
    assert len(rows_of(archive)) == 1
    assert len(rows_of(archive, "points")) == 2
    assert len(rows_of(archive, copies=True)) == 2


def test_rebuilding_drops_only_deleted_runs(archive, runs):
    gone = store_run(runs, "gone")
    store_run(runs, "here")
    index(archive, [runs])
    before = {table: rows_of(archive, table) for table in ("runs", "points", "figures", "inputs")}
    shutil.rmtree(gone)
    rebuild(archive, [])
    for table, rows in before.items():
        assert rows_of(archive, table) == [row for row in rows if row["run_id"] == "here"]


def test_archive_holds_several_folders(archive, tmp_path):
    one, two = tmp_path / "a", tmp_path / "b"
    store_run(one, "same-name")
    store_run(two, "same-name")
    assert [indexed.new for indexed in index(archive, [one, two])] == [1, 1]
    assert {row["folder"] for row in rows_of(archive)} == {
        str(one / "same-name"),
        str(two / "same-name"),
    }


def test_archive_moves_with_its_folder(runs, tmp_path):
    store_run(runs, "one")
    archive = open_archive(runs)
    index(archive, [runs])
    archive.close()
    moved = tmp_path / "elsewhere"
    runs.rename(moved)
    (row,) = query(runs=moved)
    assert row["folder"] == str(moved / "one")
    archive = open_archive(moved)
    assert index(archive, [moved])[0].new == 0
    archive.close()


def test_missing_folder_and_single_run_are_refused(archive, runs):
    with pytest.raises(UsageError, match="there is no folder"):
        index(archive, [runs / "nowhere"])
    folder = store_run(runs, "one")
    with pytest.raises(UsageError, match="is a run"):
        index(archive, [folder])


def test_archive_of_another_version_needs_a_rebuild(archive, runs):
    store_run(runs, "one")
    index(archive, [runs])
    with archive.writing() as connection:
        connection.exec_driver_sql("UPDATE archive SET value = '0'")
        connection.exec_driver_sql("DROP TABLE figures")
    with pytest.raises(DataError, match="is of version 0") as caught:
        rows_of(archive)
    assert "rebuild" in caught.value.hint
    rebuild(archive, [runs])
    assert len(rows_of(archive)) == 1


def test_file_that_is_not_an_archive_is_refused(tmp_path):
    (tmp_path / "text.sqlite").write_text("no database at all, but text\n" * 50)
    with pytest.raises(DataError, match="reported an error") as caught:
        query(database=str(tmp_path / "text.sqlite"))
    assert "remove the file; 'rigrunner archive index FOLDER' rebuilds it" in caught.value.hint
    with pytest.raises(UsageError, match="there is no archive"):
        query(database=str(tmp_path / "none.sqlite"))


def test_unreadable_folders_are_reported(archive, runs, monkeypatch):
    store_run(runs, "one")
    (runs / "locked").mkdir()
    original = os.scandir

    def scandir(path):
        if str(path).endswith("locked"):
            raise PermissionError(13, "Permission denied", str(path))
        return original(path)

    monkeypatch.setattr(os, "scandir", scandir)
    (indexed,) = index(archive, [runs])
    assert indexed.unreadable == (("locked", "the folder cannot be read: Permission denied"),)
