"""The reference pages for notebooks list exactly the public members."""

from __future__ import annotations

import re
from dataclasses import fields

import pytest

from helpers_docs import ROOT
from rigrunner_fleet.archive import Rows
from rigrunner_fleet.archive.filters import KNOWN
from rigrunner_fleet.archive.schema import TABLES
from rigrunner_fleet.notebook import Analysis, Run

PYTHON = (ROOT / "docs/reference/python.md").read_text(encoding="utf-8")
ARCHIVE = (ROOT / "docs/reference/archive.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", [Rows, Run, Analysis])
def test_public_members_are_on_the_python_page(kind):
    (rows,) = re.findall(rf"^\| `{kind.__name__}` \|.*?\n\n", PYTHON, re.MULTILINE | re.DOTALL)
    cells = "".join(re.findall(r"^\|[^|]*\|", rows, re.MULTILINE))
    documented = set(re.findall(r"`(\w+)(?:\([^`]*\))?`", cells)) - {kind.__name__, "len"}
    members = {name for name in vars(kind) if not name.startswith("_")}
    members |= {field.name for field in fields(kind)}
    assert documented == members


def test_filters_are_on_the_python_page():
    (paragraph,) = re.findall(r"The filters are.*?\n\n", PYTHON, re.DOTALL)
    assert set(KNOWN) - set(re.findall(r"`(\w+)", paragraph)) == set()


@pytest.mark.parametrize("name", list(TABLES))
def test_columns_are_on_the_archive_page(name):
    (section,) = re.findall(rf"^### {name}\n(.*?)(?=^### |\Z)", ARCHIVE, re.MULTILINE | re.DOTALL)
    first = "".join(re.findall(r"^\|[^|]*\|", section, re.MULTILINE))
    columns = {column.name for column in TABLES[name].c}
    assert set(re.findall(r"`(\w+)`", first)) == columns - {"id", "root", "stamp", "run"}
