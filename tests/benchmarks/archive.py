"""The archive: 10,000 run files indexed and searched, on SQLite and on PostgreSQL.

The run files are copies of one sealed run with the result of the demonstration and short
recordings, each with its own id, specimen, lot, rig, time and torque, and a valid manifest; the
short form has 60, with a result of two points. They are in ten folders, one of which is indexed in
each turn, by one process, just after they were written.

The floor of indexing opens each file with h5py and reads its attributes and the text of its result,
without parsing it. The floor of an index of unchanged files walks the folders and gets the size and
time of each file. The floor of a search is the same query written by hand in SQL, on the same
database, by sqlite3 or psycopg, on an open connection, and returns only the ids of the runs. A
search without an archive would take the second row times the number of files.
"""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
import tempfile
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np
import psycopg
from sqlalchemy import event

from benchmarks.frame import (
    Figure,
    Spread,
    Work,
    at_most,
    calls,
    pair_of,
    paired,
    repeated,
    seconds,
)
from helpers_cli import call
from rigrunner.runfile import seal
from rigrunner.runfile.manifest import MANIFEST, object_digest
from rigrunner_fleet.archive import index, open_archive, query
from unit.rigrunner_fleet.archive.helpers_archive import (
    has_postgresql,
    postgresql_server,
    result_document,
)
from unit.runfile.helpers_runfile import header_of, recording, write_run

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

    from benchmarks.frame import Scale
    from rigrunner_fleet.archive.database import Database

    Raw = Callable[[Database], AbstractContextManager[Callable[[str], object]]]

START = datetime(2020, 1, 1, tzinfo=UTC)
RIGS, LOTS, TYPES = 10, 200, 5
_SPARE = "spare"
"""Padding in the result of the template: numbers of the copies may have more digits."""


def template(folder: Path, document: dict) -> Path:
    """Seal a run of short recordings with a result, to be copied."""
    folder.mkdir()
    names = [point["recording"] for point in document["points"]]
    recordings = [recording(name, samples=200, seed=number) for number, name in enumerate(names, 1)]
    inputs = {"specimen": "SN-000000", "type": "GE-0", "lot": "L-000", "operator": "Ann"}
    write_run(folder, recordings, header=header_of("run-000000", inputs=inputs, station_id="rig-0"))
    seal(folder, {**document, _SPARE: " " * 2000})
    return folder


def make_many(root: Path, count: int, source: Path) -> Iterator[Path]:
    """Make run folders in a folder per month; yield each. Torques are normal about 0.72 N·m."""
    with h5py.File(source / "run.h5") as file:
        document = json.loads(bytes(file["entry/analysis/result"][()]))
        del document[_SPARE]
        manifest = json.loads(bytes(file["entry"][MANIFEST][()]))
    rng = np.random.default_rng(1)
    for number in range(count):
        started = START + timedelta(minutes=13 * number)
        folder = root / f"{started:%Y-%m}" / f"{started:%Y%m%dT%H%M%SZ}_run-{number:06d}"
        folder.mkdir(parents=True)
        shutil.copyfile(source / "run.h5", folder / "run.h5")
        torque_nm = round(float(rng.normal(0.72, 0.05)), 6)
        _change(folder / "run.h5", number, started, _result(document, torque_nm), manifest)
        yield folder


def _result(document: dict, torque_nm: float) -> dict:
    shift = torque_nm - document["headline"]["compensated"]["value"]
    headline = {**document["headline"]["compensated"], "value": torque_nm}
    method = document["headline"]["method"]
    points = [
        {**point, "torque": {**point["torque"], "value": point["torque"]["value"] + shift}}
        for point in document["compensations"][method]["points"]
    ]
    compensations = document["compensations"]
    verdict = "pass" if torque_nm < 0.8 else "fail"
    return {
        **document,
        "headline": {**document["headline"], "compensated": headline},
        "decision": {**document["decision"], "verdict": verdict},
        "compensations": {**compensations, method: {**compensations[method], "points": points}},
    }


def _change(path: Path, number: int, started: datetime, document: dict, manifest: dict) -> None:
    items = dict(manifest["items"])
    with h5py.File(path, "r+") as file:
        entry = file["entry"]
        entry.attrs["run_id"] = f"run-{number:06d}"
        entry.attrs["station_id"] = f"rig-{number % RIGS}"
        entry.attrs["started_utc"] = f"{started:%Y-%m-%dT%H:%M:%S.000Z}"
        inputs = {
            "specimen": f"SN-{number:06d}",
            "lot": f"L-{number % LOTS:03d}",
            "type": f"GE-{number % TYPES}",
        }
        for name, text in inputs.items():
            entry[f"inputs/{name}"].attrs["text"] = text
        text = json.dumps(document, ensure_ascii=False).encode()
        result = entry["analysis/result"]
        result[...] = np.frombuffer(text.ljust(result.size), np.uint8)
        changed = [".", "analysis/result", *(f"inputs/{name}" for name in inputs)]
        for name in changed:
            item = entry if name == "." else entry[name]
            items[name] = {**items[name], "sha256": object_digest(item, name)}
        content = json.dumps({**manifest, "items": items}, sort_keys=True, separators=(",", ":"))
        entry[MANIFEST][...] = np.frombuffer(content.encode(), np.uint8)


FOLDERS, TURNS = 10, 9
LOOKING = "a digest of the names, sizes and times of each folder"
READING = "h5py's Python, a call for each text, and the JSON of the result"
ROWS = "SQLAlchemy makes the statement, and each row has every column"


def measure(scale: Scale) -> list[Figure]:
    count = scale.of(10_000, 60)
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        document = result_document() if scale.short else demonstration_result(Path(folder))
        roots = make_roots(Path(folder), count, document)
        figures = measure_on(roots, str(Path(folder) / "lab.sqlite"), "SQLite", raw_sqlite)
        if not has_postgresql():
            return [*figures, Figure("PostgreSQL", None, "s", note="there is none here")]
        place = stack.enter_context(postgresql_server())
        return figures + measure_on(
            roots, f"postgresql://rigrunner@/postgres{place}", "PostgreSQL", raw_postgresql
        )


def measure_on(roots: list[Path], database: str, name: str, raw: Raw) -> list[Figure]:
    """Return all figures of one engine."""
    with closing(open_archive(database=database)) as archive:
        archive.make()
        figures = [*indexing(archive, roots), *unchanged(archive, roots)]
        with raw(archive) as ask:
            for question in QUESTIONS:
                figures += searching(database, question, ask)
        figures += [frame(database), size_of_a_run(archive, len(query(database=database)))]
    return [replace(figure, what=f"{name}: {figure.what}") for figure in figures]


def indexing(archive: Database, roots: list[Path]) -> list[Figure]:
    turns = [
        (seconds(partial(index, archive, [root])), seconds(partial(read_files, root)))
        for root in roots
    ]
    pair, count = pair_of(turns), sum(1 for _ in files(roots[0])) / 1e3
    ours = Figure("read a new run file", pair.ours.per(count), "ms", ratio=pair.ratio)
    return [
        replace(ours, target=at_most(10), note=READING),
        Figure("open it, attributes and result", pair.floor.per(count), "ms", "floor"),
    ]


def unchanged(archive: Database, roots: list[Path]) -> list[Figure]:
    pair = paired(partial(index, archive, roots), partial(walk, roots), TURNS)
    ours = Figure("find nothing new in all", pair.ours, "s", ratio=pair.ratio)
    return [
        replace(ours, target=at_most(2, "s"), note=LOOKING),
        Figure("walk all folders", pair.floor, "s", "floor"),
    ]


def searching(database: str, question: Question, ask: Callable[[str], object]) -> list[Figure]:
    ours = partial(query, database=database, **question.filters)
    pair = paired(ours, partial(ask, question.statement), TURNS)
    figure = Figure(question.what, pair.ours.per(1e-3), "ms", ratio=pair.ratio)
    return [
        replace(figure, target=at_most(100, "ms"), note=f"{len(ours()):,} rows; {ROWS}"),
        Figure(f"{question.what}, by hand", pair.floor.per(1e-3), "ms", "floor"),
    ]


def frame(database: str) -> Figure:
    count = len(query("points", database=database))
    duration = repeated(lambda: query("points", database=database).to_pandas(), 3)
    note = "rows of Python, then columns"
    return Figure(f"{count:,} points as a data frame", duration, "s", note=note)


def size_of_a_run(archive: Database, runs: int) -> Figure:
    what = "size of the archive, a run of 12 set-points"
    return Figure(what, Spread.of([size(archive) / runs / 1e3]), "kB", target=at_most(10, "kB"))


@dataclass(frozen=True)
class Question:
    """A search: its name, its filters, and the same in SQL."""

    what: str
    filters: dict[str, str]
    statement: str


QUESTIONS = (
    Question(
        "one specimen",
        {"specimen": "SN-000123"},
        "SELECT run_id FROM runs WHERE specimen = 'SN-000123'",
    ),
    Question(
        "a month and a verdict",
        {"since": "2020-02-01", "until": "2020-02-29", "verdict": "fail"},
        "SELECT run_id FROM runs WHERE started_utc >= '2020-02-01'"
        " AND started_utc < '2020-03-01' AND verdict = 'fail'",
    ),
    Question(
        "a lot by pattern, a range of torque",
        {"lot": "L-01*", "torque": "0.7..0.75 N·m"},
        "SELECT run_id FROM runs WHERE lot LIKE 'L-01%' AND torque_nm BETWEEN 0.7 AND 0.75",
    ),
    Question(
        "a torque at one frequency",
        {"frequency": "10 Hz", "torque": "0.8..9 N·m"},
        "SELECT run_id FROM runs r WHERE EXISTS (SELECT 1 FROM points p WHERE p.run = r.id"
        " AND p.set_frequency_hz BETWEEN 9.9999 AND 10.0001 AND p.torque_nm BETWEEN 0.8 AND 9)",
    ),
)


@contextmanager
def raw_sqlite(archive: Database) -> Iterator[Callable[[str], object]]:
    with closing(sqlite3.connect(str(archive.file))) as connection:
        yield lambda statement: connection.execute(statement).fetchall()


@contextmanager
def raw_postgresql(archive: Database) -> Iterator[Callable[[str], object]]:
    location = archive.location.set(drivername="postgresql").render_as_string()
    with psycopg.connect(location) as connection:
        yield lambda statement: connection.execute(statement).fetchall()


def demonstration_result(folder: Path) -> dict[str, object]:
    """Run the demonstration and return its result."""
    call("demo", "--dir", str(folder / "demo"))
    (result,) = (folder / "demo").glob("*STT-1000*/result.json")
    document: dict[str, object] = json.loads(result.read_text(encoding="utf-8"))
    return document


def make_roots(folder: Path, count: int, document: object) -> list[Path]:
    """Make run files with this result, and return their folders."""
    source = template(folder / "template", document)
    runs = make_many(folder / "all", count, source)
    roots = [folder / f"part-{number}" for number in range(FOLDERS)]
    for number, run in enumerate(runs):
        part = roots[number * FOLDERS // count] / run.parent.name
        part.mkdir(parents=True, exist_ok=True)
        run.rename(part / run.name)
    return roots


def files(root: Path) -> Iterator[Path]:
    for folder, _, names in os.walk(root):
        yield from (Path(folder, name) for name in names)


def read_files(root: Path) -> None:
    """Open each file, and read its attributes and its result."""
    for path in files(root):
        with h5py.File(path) as file:
            dict(file["entry"].attrs)
            bytes(file["entry/analysis/result"][()])


def walk(roots: list[Path]) -> None:
    for root in roots:
        for path in files(root):
            path.stat()


def size(archive: Database) -> int:
    """Return the bytes of the archive on the disk."""
    if archive.file is not None:
        with archive.writing() as connection:
            pages = connection.exec_driver_sql("PRAGMA page_count").scalar_one()
            return int(pages * connection.exec_driver_sql("PRAGMA page_size").scalar_one())
    with archive.reading() as connection:
        return int(
            connection.exec_driver_sql(
                "SELECT pg_database_size(current_database())"
                " - (SELECT pg_database_size('template1'))"
            ).scalar_one()
        )


def work() -> list[Work]:
    count = 40
    with tempfile.TemporaryDirectory() as folder:
        source = template(Path(folder) / "template", result_document())
        for _ in make_many(Path(folder) / "runs", count, source):
            pass
        with closing(open_archive(Path(folder) / "runs")) as archive:
            index_runs = partial(index, archive, [Path(folder) / "runs"])
            statements = count_statements(archive, index_runs)
            calls_unchanged = calls(index_runs)
            statements_unchanged = count_statements(archive, index_runs)
        return [
            Work("statements for a new run", statements / count, 3),
            Work("statements where nothing is new", statements_unchanged, 25),
            Work("calls of functions for an unchanged run", calls_unchanged / count, 400),
        ]


def count_statements(archive: Database, call: Callable[[], object]) -> int:
    """Return the number of statements that a call executes in an archive."""
    statements: list[str] = []

    def record(_c: object, _u: object, statement: str, *_: object) -> None:
        statements.append(statement)

    event.listen(archive._engine, "before_cursor_execute", record)
    try:
        call()
    finally:
        event.remove(archive._engine, "before_cursor_execute", record)
    return len(statements)
