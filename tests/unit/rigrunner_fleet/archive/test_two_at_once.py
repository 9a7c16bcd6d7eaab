"""Several processes index a folder while others search it."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from contextlib import closing, suppress

import pytest

from rigrunner.api.errors import UsageError
from rigrunner_fleet.archive import index, open_archive, query
from unit.rigrunner_fleet.archive.helpers_archive import store_run

_RUNS, _PROCESSES = 15, 3
_INDEX = """
import sys
from pathlib import Path
from rigrunner.api.errors import UsageError
from rigrunner_fleet.archive import index, open_archive
archive = open_archive(database=sys.argv[1])
for _ in range(3):
    index(archive, [Path(sys.argv[2])], again=True)
"""


@pytest.fixture
def many(runs):
    first = store_run(runs, "run-0", inputs={"specimen": "SN"})
    for number in range(1, _RUNS):
        shutil.copytree(first, runs / f"run-{number}")
    return runs


@pytest.mark.thorough
def test_concurrent_indexing_stores_each_run_once(database, many):
    command = [sys.executable, "-c", _INDEX, database, str(many)]
    workers = [subprocess.Popen(command) for _ in range(_PROCESSES)]
    states = set()
    while any(worker.poll() is None for worker in workers):
        states |= count_rows(database)
        time.sleep(0.01)
    assert [worker.returncode for worker in workers] == [0] * _PROCESSES
    assert states <= {(0, 0, 0)} | {(n, 2 * n, n) for n in range(_RUNS + 1)}, (
        "no run is half stored"
    )
    assert count_rows(database) == {(_RUNS, 2 * _RUNS, _RUNS)}


def count_rows(database: str) -> set[tuple[int, int, int]]:
    """Return the numbers of runs, points and inputs at one time; empty before the tables exist."""
    with closing(open_archive(database=database)) as archive, suppress(UsageError):
        with archive.reading() as connection:
            counts = connection.exec_driver_sql(
                "SELECT (SELECT count(*) FROM runs), (SELECT count(*) FROM points),"
                " (SELECT count(*) FROM inputs)"
            ).one()
        return {tuple(counts)}
    return set()


def test_search_during_a_write_sees_the_previous_state(database, many):
    archive = open_archive(database=database)
    index(archive, [many])
    with archive.writing() as connection:
        connection.exec_driver_sql("DELETE FROM runs")
        assert len(query(database=database, copies=True)) == _RUNS
    archive.close()
    assert len(query(database=database, copies=True)) == 0
