"""Archives made by earlier versions are upgraded."""

from __future__ import annotations

import shutil
from contextlib import closing
from pathlib import Path

import pytest

from rigrunner.api.errors import DataError
from rigrunner_fleet.archive import index, open_archive, query, rebuild
from unit.rigrunner_fleet.archive.helpers_archive import store_run
from unit.rigrunner_fleet.archive.helpers_named_results import LIMITS_OHM, store_resistances

SCRIPT = Path(__file__).parents[3] / "data" / "archives" / "version-2.sql"
ON_POSTGRESQL = {
    " WITHOUT ROWID": "", "DOUBLE": "DOUBLE PRECISION", "DATETIME": "TIMESTAMP",
    "9e999": "'Infinity'", "id INTEGER NOT NULL": "id SERIAL",
}  # fmt: skip


@pytest.fixture(params=[1, 2])
def old(request, database, runs):
    """Make an archive of a missing run and a damaged one, and store a run beside it."""
    script = SCRIPT.read_text(encoding="utf-8")
    if database.startswith("postgresql"):
        for sqlite, postgresql in ON_POSTGRESQL.items():
            script = script.replace(sqlite, postgresql)
    if request.param == 1:
        script += "DROP TABLE coordinates;\nDROP TABLE results;\nUPDATE archive SET value = '1';\n"
    with closing(open_archive(database=database)) as archive, archive.writing() as connection:
        for statement in script.split(";\n")[:-1]:
            connection.exec_driver_sql(statement)
    store_run(runs, "kept")
    return database, request.param


def test_indexing_upgrades_and_keeps_missing_runs(old, runs):
    database, version = old
    with pytest.raises(DataError, match=f"of version {version}") as caught:
        query(database=database)
    assert "archive index" in caught.value.hint
    with closing(open_archive(database=database)) as archive:
        (first,) = index(archive, [runs])
        assert first.new == 1, "missing runs are not read"
        (again,) = index(archive, [runs])
        assert (again.new, again.changed) == (0, 0)
    runs_by_id = {row["run_id"]: row for row in query(database=database)}
    assert sorted(runs_by_id) == ["damaged", "gone", "kept"]
    assert (runs_by_id["gone"]["missing"], runs_by_id["gone"]["rule"]) == (True, "simple")
    assert runs_by_id["gone"]["digest_sha256"][:8] == "f8e2fcbb"
    assert "not an HDF5 file" in runs_by_id["damaged"]["problem"]
    assert (runs_by_id["damaged"]["torque_nm"], runs_by_id["damaged"]["failed_checks"]) == (0.72, 2)
    assert not runs_by_id["kept"]["missing"]


def test_rows_of_missing_runs_are_kept(old, runs):
    database, version = old
    with closing(open_archive(database=database)) as archive:
        index(archive, [runs])

    def rows_of(table, run, *columns, **filters):
        rows = query(table, database=database, **filters)
        return [tuple(row[column] for column in columns) for row in rows if row["run_id"] == run]

    results = rows_of("results", "gone", "place", "value", "unit", "verdict", "lower", "si_value")
    assert results == ([] if version == 1 else [
        ("chamber.temperature = 0 °C", 100020.0, "mΩ", "pass", 99883.0, 100.02),
        ("chamber.temperature = 100 °C", 138950.0, "mΩ", "fail", 138203.0, 138.95),
    ])  # fmt: skip
    at_100 = {"result": {"resistance": "138..139 Ω"}, "where": {"temperature": "373.15 K"}}
    assert rows_of("results", "gone", "value", **at_100) == [
        (value,) for _, value, *_ in results[1:]
    ]
    assert rows_of("points", "damaged", "recording", "torque_nm", "dof") == [
        ("001", 0.73, float("inf")), ("002", 0.74, float("inf")),
    ]  # fmt: skip
    assert rows_of("figures", "damaged", "source", "name", "value", "unit")[1] == (
        "template_inverse", "inertia", 0.00232, "kg·m²",
    )  # fmt: skip
    ((decided_utc, reason),) = rows_of("decisions", "gone", "decided_utc", "reason")
    assert (decided_utc.isoformat(), reason) == ("2026-03-01T12:00:00+00:00", "made")
    assert rows_of("inputs", "gone", "name", "value") == [("specimen", "Pt-1")]
    ((name, sha256), (_, none)) = rows_of("files", "gone", "name", "sha256")
    assert (name, sha256[:8], none) == ("note.txt", "47a8dea6", "")


def test_limits_of_version_3_are_read_again(database, runs):
    """Version 3 kept one of two entries with min and max: a Cpl of 2.5 for a Cpk of 0.8."""
    kept, gone = [store_resistances(runs, name, {0.0: 100.0}) for name in ("kept", "gone")]
    with closing(open_archive(database=database)) as archive:
        index(archive, [runs])
        shutil.rmtree(gone)
        index(archive, [runs])
        with archive.writing() as connection:
            connection.exec_driver_sql("UPDATE results SET upper = NULL")
            connection.exec_driver_sql("UPDATE archive SET value = '3'")

    with pytest.raises(DataError, match="is of version 3, this program's is 4") as caught:
        query("results", database=database)
    assert "archive index" in caught.value.hint
    with closing(open_archive(database=database)) as archive:
        index(archive, [runs])
    rows = query("results", database=database)
    assert {row["run_id"]: (row["lower"], row["upper"]) for row in rows} == {
        "kept": LIMITS_OHM[0.0],
        "gone": (None, None),
    }
    assert kept.exists()


def test_old_archive_can_be_rebuilt(old, runs):
    database, _ = old
    with closing(open_archive(database=database)) as archive:
        rebuild(archive, [runs])
    assert query(database=database).column("run_id") == ["kept"]
