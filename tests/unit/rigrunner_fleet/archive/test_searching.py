"""Queries on both engines, compared with a search of the same rows in Python."""

from __future__ import annotations

import random
import re
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sqlalchemy import text

from helpers_thorough import examples
from rigrunner.api.errors import UsageError
from rigrunner.runfile.scan import FoundRun
from rigrunner_fleet.archive import open_archive, query
from rigrunner_fleet.archive.filters import filters_of
from rigrunner_fleet.archive.querying import rows
from rigrunner_fleet.archive.run_facts import RunFacts
from rigrunner_fleet.archive.searching import select_rows
from rigrunner_fleet.archive.storing import root_of, store

START = datetime(2026, 3, 1, 12, tzinfo=UTC)
NAMES = ["SN-1", "SN-2", "sn-1", "S%", "S_1", "S\\1", "[S]", "SN?1", "É", "SN-1 ", "'", "", None]
PATTERNS = ["SN-*", "*1", "S?1", "*", "[S]*", "S%*", "S\\*", "?", "É*"]
TYPES = ["GE20", "GE25", None]
TORQUES = [0.5, 0.7, 0.70001, 0.95, -0.1, None]
FREQUENCIES = [1.0, 10.0, 35.0]
HOURS = [*range(0, 100, 3), 36, 39]
"""After START; the times of the filters are among them."""


def random_rows() -> list[dict]:
    """Return rows as indexing would store them: names in turn, everything else random."""
    rng = random.Random(1)  # noqa: S311  (no secret)
    return [
        {
            "run_id": f"run-{number}",
            "digest_sha256": f"{number:064d}",
            "started_utc": START + timedelta(hours=HOURS[number % len(HOURS)]),
            "specimen": NAMES[number % len(NAMES)],
            "type": rng.choice(TYPES),
            "rig": rng.choice(["rig-1", "rig-2"]),
            "verdict": rng.choice(["pass", "fail", None]),
            "torque_nm": rng.choice(TORQUES),
            "simulated": rng.random() < 0.3,
            "replayed": rng.random() < 0.3,
            "points": [
                (rng.choice(FREQUENCIES), rng.choice(TORQUES)) for _ in range(rng.randint(0, 3))
            ],
            "order": rng.choice(["A-1", "A-2", None]),
            "inertia": rng.choice([0.0022, 0.0024, None]),
        }
        for number in range(5 * len(NAMES))
    ]


OPTIONS = {
    "specimen": st.lists(st.sampled_from([*NAMES[:-2], *PATTERNS]), min_size=1, max_size=2),
    "type": st.sampled_from(["GE20", "GE2?", "ge20"]),
    "rig": st.sampled_from(["rig-1", "rig-*", "nothing"]),
    "verdict": st.lists(st.sampled_from(["pass", "fail", "none"]), min_size=1, max_size=2),
    "torque": st.sampled_from(["0.5..0.7 N·m", "0.7 N·m..", "..700.005 mN·m", "2..3 N·m"]),
    "frequency": st.sampled_from(["10 Hz", "5..40 Hz", "60..60 rpm"]),
    "since": st.sampled_from(["2026-03-01", "2026-03-03T05:00+02:00"]),
    "until": st.sampled_from(["2026-03-02", "2026-03-03T05:00+02:00"]),
    "real": st.just(True),  # noqa: FBT003  (a strategy of one value)
    "inputs": st.sampled_from([{"order": "A-1"}, {"order": ["A-*"]}, {"none": "*"}]),
    "figures": st.sampled_from(
        [{"inertia": "0.002..0.0023 kg·m²"}, {"model/inertia": "0.0023 kg·m².."}]
    ),
}
FILTERS = st.lists(st.sampled_from(list(OPTIONS)), max_size=3, unique=True).flatmap(
    lambda names: st.fixed_dictionaries({name: OPTIONS[name] for name in names})
)
"""At most three: many filters together match no row."""


def store_rows(archive, data):
    """Put rows into an empty archive."""
    archive.make()
    archive.empty()
    facts = [_facts(row) for row in data]
    with archive.writing() as connection:
        store(connection, root_of(connection, archive.file, Path("/nowhere")), facts)


def _facts(row):
    parts = {"points", "order", "inertia"}
    run = {name: value for name, value in row.items() if name not in parts} | {"problem": ""}
    return RunFacts(
        FoundRun(row["run_id"], Path(row["run_id"]), ()),
        run,
        {
            "points": [
                {"number": number, "set_frequency_hz": frequency, "torque_nm": torque}
                for number, (frequency, torque) in enumerate(row["points"], 1)
            ],
            "inputs": [{"name": "order", "value": row["order"]}] if row["order"] else [],
            "figures": [
                {"source": "model", "name": "inertia", "value": row["inertia"], "unit": "kg·m²"}
            ],
        },
    )


LIMITS = {
    "0.5..0.7 N·m": (0.5, 0.7), "0.7 N·m..": (0.7, 9), "..700.005 mN·m": (-9, 0.700005),
    "2..3 N·m": (2, 3), "10 Hz": (9.99999, 10.00001), "5..40 Hz": (5, 40), "60..60 rpm": (1, 1),
    "0.002..0.0023 kg·m²": (0.002, 0.0023), "0.0023 kg·m²..": (0.0023, 9),
}  # fmt: skip
FIRST = {
    "2026-03-01": datetime(2026, 3, 1, tzinfo=UTC),
    "2026-03-03T05:00+02:00": datetime(2026, 3, 3, 3, tzinfo=UTC),
}
LAST = {
    "2026-03-02": datetime(2026, 3, 2, 23, 59, 59, 999999, tzinfo=UTC),
    "2026-03-03T05:00+02:00": datetime(2026, 3, 3, 3, tzinfo=UTC),
}


def matches_any(value, patterns):
    """Return whether a text matches one of the patterns, with a regular expression."""
    patterns = [patterns] if isinstance(patterns, str) else patterns
    return any(
        value is not None
        and re.fullmatch(
            "".join({"*": "(?s:.*)", "?": "(?s:.)"}.get(sign, re.escape(sign)) for sign in pattern),
            value,
        )
        for pattern in patterns
    )


def within(value, text):
    low, high = LIMITS[text]
    return value is not None and low <= value <= high


def point_fits(point, filters):
    return within(point[0], filters["frequency"]) and (
        "torque" not in filters or within(point[1], filters["torque"])
    )


def fits(row, filters):
    """Return whether a row matches the filters, computed in Python."""
    checks = {
        "specimen": lambda text: matches_any(row["specimen"], text),
        "type": lambda text: matches_any(row["type"], text),
        "rig": lambda text: matches_any(row["rig"], text),
        "verdict": lambda allowed: (row["verdict"] or "none") in allowed,
        "torque": lambda text: "frequency" in filters or within(row["torque_nm"], text),
        "frequency": lambda _: any(point_fits(point, filters) for point in row["points"]),
        "since": lambda text: row["started_utc"] >= FIRST[text],
        "until": lambda text: row["started_utc"] <= LAST[text],
        "real": lambda _: not (row["simulated"] or row["replayed"]),
        "inputs": lambda inputs: all(
            name == "order" and matches_any(row["order"], text) for name, text in inputs.items()
        ),
        "figures": lambda figures: all(within(row["inertia"], text) for text in figures.values()),
    }
    return all(checks[name](value) for name, value in filters.items())


def compare(archive, data, filters):
    """Compare a query of the archive with the search in Python."""
    runs = rows(archive, "runs", filters_of(**filters))
    points = rows(archive, "points", filters_of(**filters))
    expected = sorted(
        (row for row in data if fits(row, filters)),
        key=lambda row: (row["started_utc"], int(row["run_id"][4:])),
    )
    assert runs.column("run_id") == [row["run_id"] for row in expected]
    assert list(zip(points.column("run_id"), points.column("torque_nm"), strict=True)) == [
        (row["run_id"], torque)
        for row in expected
        for frequency, torque in row["points"]
        if "frequency" not in filters or point_fits((frequency, torque), filters)
    ]


def test_queries_equal_a_search_in_python(database):
    data = random_rows()
    with closing(open_archive(database=database)) as archive:
        store_rows(archive, data)

        @settings(max_examples=examples(60), deadline=None)
        @given(filters=FILTERS)
        def check(filters):
            compare(archive, data, filters)

        check()
        for name in (*NAMES[:-2], *PATTERNS):
            compare(archive, data, {"specimen": [name]})
        for name in ("since", "until"):
            for text in FIRST if name == "since" else LAST:
                compare(archive, data, {name: text})


INJECTIONS = ["' OR '1'='1", "'; DROP TABLE runs; --", '" OR 1=1 --', "\\'; --", "%", "x' GLOB '*"]


@pytest.mark.parametrize("text", INJECTIONS)
def test_sql_injection_matches_nothing(database, text):
    with closing(open_archive(database=database)) as archive:
        store_rows(archive, three_rows())
        for filters in ({"specimen": text}, {"inputs": {text: text}}, {"specimen": f"{text}*"}):
            assert len(rows(archive, "runs", filters_of(**filters))) == 0
        assert len(rows(archive, "runs", filters_of())) == 3


def three_rows():
    blank = {
        "type": None, "rig": "rig-1", "verdict": "pass", "simulated": False, "replayed": False,
        "points": [], "order": None, "inertia": None, "specimen": "SN-1", "torque_nm": 0.7,
    }  # fmt: skip
    return [
        {
            **blank,
            "run_id": f"run-{day}",
            "digest_sha256": f"{day:064d}",
            "started_utc": START + timedelta(days=day),
        }
        for day in range(3)
    ]


def test_limit_keeps_the_newest_runs_in_order(database):
    with closing(open_archive(database=database)) as archive:
        store_rows(archive, three_rows())
        newest = rows(archive, "runs", filters_of(), limit=2)
        assert newest.column("run_id") == ["run-1", "run-2"]
        with pytest.raises(UsageError, match="selects nothing"):
            rows(archive, "runs", filters_of(), limit=0)


def test_newest_runs_are_read_by_index(database):
    """Sorting a million runs takes a second."""
    with closing(open_archive(database=database)) as archive:
        store_rows(archive, three_rows())
        with archive.reading() as connection:
            sqlite = connection.dialect.name == "sqlite"
            # PostgreSQL would not use the index for three rows.
            connection.execute(text("SELECT 1" if sqlite else "SET enable_seqscan = off"))
            select = select_rows("runs", filters_of(), connection.dialect, 2)
            statement = select.compile(connection, compile_kwargs={"literal_binds": True})
            explain = "EXPLAIN QUERY PLAN" if sqlite else "EXPLAIN"
            plan = "\n".join(map(str, connection.exec_driver_sql(f"{explain} {statement}")))
    assert ("USING INDEX runs_by_start" if sqlite else "Backward using runs_by_start") in plan


def test_run_without_a_start_time_sorts_first(database):
    stored_rows = three_rows()
    stored_rows[1]["started_utc"] = None
    with closing(open_archive(database=database)) as archive:
        store_rows(archive, stored_rows)
        assert rows(archive, "runs", filters_of()).column("run_id") == ["run-1", "run-0", "run-2"]
        assert rows(archive, "runs", filters_of(), limit=1).column("run_id") == ["run-2"]


@pytest.mark.parametrize(
    ("filters", "message", "hint"),
    [
        ({"specimn": "A"}, "there is no filter 'specimn'", "did you mean 'specimen'"),
        ({"verdict": "passed"}, "there is no verdict 'passed'", "conditional pass"),
        ({"outcome": ["completed", "gone"]}, "there is no outcome 'gone'", "aborted"),
        ({"torque": "0.7 N·m"}, "is not a range", "0.5..0.8"),
    ],
)
def test_invalid_filters_are_refused(filters, message, hint):
    with pytest.raises(UsageError, match=message) as caught:
        filters_of(**filters)
    assert hint in caught.value.hint


def test_unknown_table_is_refused(tmp_path):
    with closing(open_archive(tmp_path)) as archive:
        archive.make()
    with pytest.raises(UsageError, match="no table 'roots'"):
        query("roots", runs=tmp_path)
