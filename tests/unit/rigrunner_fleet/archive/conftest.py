"""Archives on both engines: a test with the fixture `database` runs once on each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import psycopg
import pytest

from unit.rigrunner_fleet.archive.helpers_archive import postgresql_server

if TYPE_CHECKING:
    from pathlib import Path

_CLEAR_DATABASE = (
    """SELECT pg_terminate_backend(pid) FROM pg_stat_activity
    WHERE datname = 'postgres' AND pid <> pg_backend_pid()""",
    "DROP SCHEMA public CASCADE",
    "CREATE SCHEMA public",
)
"""Faster than a database per test: removing its 300 files takes longer than all archive tests."""


@pytest.fixture(scope="session")
def server():
    with postgresql_server() as place:
        yield place


@pytest.fixture(params=["sqlite", "postgresql"])
def database(request, tmp_path) -> str:
    """The name of an empty database, as `--database` takes it."""
    if request.param == "sqlite":
        return str(tmp_path / "archive.sqlite")
    place = request.getfixturevalue("server")
    host = place.removeprefix("?host=")
    login = {"host": host, "user": "rigrunner", "dbname": "postgres"}
    with psycopg.connect(**login, autocommit=True) as connection:
        for statement in _CLEAR_DATABASE:
            connection.execute(statement)
    return f"postgresql://rigrunner@/postgres{place}"


@pytest.fixture
def runs(tmp_path) -> Path:
    folder = tmp_path / "runs"
    folder.mkdir()
    return folder
