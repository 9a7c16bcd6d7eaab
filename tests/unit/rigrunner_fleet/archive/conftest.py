"""Archives on both engines: each test that takes `database` runs once on each."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

import psycopg
import pytest

from unit.rigrunner_fleet.archive.helpers_archive import postgresql_server

if TYPE_CHECKING:
    from pathlib import Path

_NUMBERS = count(1)


@pytest.fixture(scope="session")
def server():
    with postgresql_server() as place:
        yield place


@pytest.fixture(params=["sqlite", "postgresql"])
def database(request, tmp_path) -> str:
    """The name of an empty database, as `--database` takes it."""
    if request.param == "sqlite":
        return str(tmp_path / "archive.sqlite")
    place, name = request.getfixturevalue("server"), f"test{next(_NUMBERS)}"
    host = place.removeprefix("?host=")
    with psycopg.connect(host=host, user="rigrunner", dbname="postgres", autocommit=True) as made:
        made.execute(f"CREATE DATABASE {name}")
    return f"postgresql://rigrunner@/{name}{place}"


@pytest.fixture
def runs(tmp_path) -> Path:
    folder = tmp_path / "runs"
    folder.mkdir()
    return folder
