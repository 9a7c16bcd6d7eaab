"""The archive of a million runs: the time of a search, and the size of the archive.

One run of the demonstration is indexed, and its rows are copied by SQL, each copy with its own id,
specimen, lot, rig, time and torque; no files are made for them. `archive` measures the indexing of
files. The runs are 13 minutes apart, over 24 years. Each search is that of `rigrunner archive
query`, including its connection, and ends with rows in Python.
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import text

from benchmarks.archive import QUESTIONS, Question, demonstration_result, size, template
from benchmarks.frame import Figure, Spread, Work, at_most, repeated
from rigrunner_fleet.archive import index, open_archive, query
from rigrunner_fleet.archive.filters import filters_of
from rigrunner_fleet.archive.schema import PARTS, RUNS
from rigrunner_fleet.archive.searching import select_rows
from unit.rigrunner_fleet.archive.helpers_archive import (
    has_postgresql,
    postgresql_server,
    result_document,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from sqlalchemy import Table

    from benchmarks.frame import Scale
    from rigrunner_fleet.archive.database import Database

RUNS_AT_ONCE = 50_000
TORQUE_NM = "(0.6 + 0.24 * (n.k % 10007 * 7919 % 10007) / 10007.0)"
"""Nearly uniform between 0.6 N·m and 0.84 N·m."""
COPIED: Mapping[str, Mapping[str, str]] = {
    "sqlite": {
        "started_utc": "strftime('%Y-%m-%d %H:%M:%S.000000', '2020-01-01',"
        " '+' || (13 * n.k) || ' minutes')",
        "digits": "printf('%07d', n.k)",
        "lot": "printf('%05d', n.k / 50)",
    },
    "postgresql": {
        "started_utc": "timestamp '2020-01-01' + n.k * interval '13 minutes'",
        "digits": "lpad(cast(n.k as text), 7, '0')",
        "lot": "lpad(cast(n.k / 50 as text), 5, '0')",
    },
}
"""Values that differ between runs, in the SQL of each database; a lot has 50 runs."""
LARGE_QUESTIONS = (
    Question("one specimen", {"specimen": "SN-0000123"}, ""),
    Question("a month and a verdict", QUESTIONS[1].filters, ""),
    Question(
        "lots by pattern, a range of torque", {"lot": "L-0001*", "torque": "0.7..0.75 N·m"}, ""
    ),
    Question("a range of torque of all runs", {"torque": "0.8399..0.84 N·m"}, ""),
    Question("a torque at one frequency", {"frequency": "10 Hz", "torque": "0.8399..9 N·m"}, ""),
    Question("the newest 100 runs that failed", {"verdict": "fail", "limit": 100}, ""),
)


def measure(scale: Scale) -> list[Figure]:
    count = scale.of(1_000_000, 200)
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder = Path(name)
        (folder / "runs").mkdir()
        document = result_document() if scale.short else demonstration_result(folder)
        template(folder / "runs" / "template", document)
        databases = {"SQLite": str(folder / "large.sqlite")}
        if has_postgresql():
            place = stack.enter_context(postgresql_server())
            databases["PostgreSQL"] = f"postgresql://rigrunner@/postgres{place}"
        return [
            replace(figure, what=f"{engine}: {figure.what}")
            for engine, database in databases.items()
            for figure in measure_on(database, folder / "runs", count)
        ]


def measure_on(database: str, runs: Path, count: int) -> list[Figure]:
    with closing(open_archive(database=database)) as archive:
        fill(archive, runs, count)
        figures = [searching(database, question) for question in LARGE_QUESTIONS]
        kilobytes = Spread.of([size(archive) / count / 1e3])
    what = f"size of the archive of {count:,} runs, a run of 12 set-points"
    return [*figures, Figure(what, kilobytes, "kB", target=at_most(4, "kB"))]


def searching(database: str, question: Question) -> Figure:
    ask = partial(query, database=database, **question.filters)
    count = len(ask())
    duration = repeated(ask, 9).per(1e-3)
    return Figure(question.what, duration, "ms", target=at_most(100, "ms"), note=f"{count:,} rows")


def fill(archive: Database, runs: Path, count: int) -> None:
    """Index the only run, and copy its rows up to this number of runs."""
    index(archive, [runs])
    copy_rows(archive, 2, count)


def copy_rows(archive: Database, begin: int, count: int) -> None:
    """Copy the rows of the first run to the runs of these numbers."""
    for first in range(begin, count + 1, RUNS_AT_ONCE):
        with archive.writing() as connection:
            for statement in copies(connection.dialect.name, first, count):
                connection.execute(text(statement))
    with archive.writing() as connection:
        connection.execute(text("ANALYZE"))


def copies(dialect: str, first: int, count: int) -> Iterator[str]:
    """Yield the statements that copy the rows of run 1 for the next runs."""
    sql, last = COPIED[dialect], min(first + RUNS_AT_ONCE - 1, count)
    numbers = (
        f"WITH RECURSIVE n(k) AS (SELECT {first} UNION ALL SELECT k + 1 FROM n WHERE k < {last})"  # noqa: S608  (our own numbers)
    )
    of_run = {
        "id": "n.k",
        "path": f"'run-' || {sql['digits']}",
        "run_id": f"'run-' || {sql['digits']}",
        "specimen": f"'SN-' || {sql['digits']}",
        "lot": f"'L-' || {sql['lot']}",
        "rig": "'rig-' || (n.k % 10)",
        "started_utc": sql["started_utc"],
        "torque_nm": TORQUE_NM,
        "verdict": f"CASE WHEN {TORQUE_NM} < 0.8 THEN 'pass' ELSE 'fail' END",
    }
    yield _copy(RUNS, numbers, of_run, "t.id")
    for part in PARTS:
        changed = {"run": "n.k"}
        if part.name == "points":
            changed["torque_nm"] = TORQUE_NM
        yield _copy(part, numbers, changed, "t.run")


def _copy(table: Table, numbers: str, changed: Mapping[str, str], key: str) -> str:
    names = [f'"{column.name}"' for column in table.columns]
    values = [changed.get(column.name, f't."{column.name}"') for column in table.columns]
    return (
        f'INSERT INTO "{table.name}" ({", ".join(names)}) {numbers}'  # noqa: S608  (our own names)
        f' SELECT {", ".join(values)} FROM n, "{table.name}" t WHERE {key} = 1'
    )


def work() -> list[Work]:
    with tempfile.TemporaryDirectory() as name:
        runs, database = Path(name) / "runs", str(Path(name) / "large.sqlite")
        runs.mkdir()
        template(runs / "template", result_document())
        with closing(open_archive(database=database)) as archive:
            fill(archive, runs, 200)
            assert len(query(database=database)) == 200, "each copy is a run"
            few = sum(steps(archive, question) for question in LARGE_QUESTIONS)
            copy_rows(archive, 201, 2000)
            many = sum(steps(archive, question) for question in LARGE_QUESTIONS)
        return [
            Work("steps of SQLite for each further run, of six searches", (many - few) / 1800, 60)
        ]


def steps(archive: Database, question: Question) -> int:
    """Return the number of instructions of SQLite's virtual machine for a search, in tens."""
    count, filters = 0, dict(question.filters)
    limit = filters.pop("limit", None)

    def count_steps() -> int:
        nonlocal count
        count += 10
        return 0

    with archive.reading() as connection:
        statement = select_rows("runs", filters_of(**filters), connection.dialect, limit)
        sqlite = connection.connection.driver_connection
        sqlite.set_progress_handler(count_steps, 10)
        connection.execute(statement).all()
        sqlite.set_progress_handler(None, 0)
    return count
