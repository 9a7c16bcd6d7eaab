"""References on disk: written and read back; other files are refused with their path."""

from __future__ import annotations

from dataclasses import asdict

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.errors import DataError, UsageError
from rigrunner_fleet.golden.figures import Figure
from rigrunner_fleet.golden.reference import (
    REFERENCE,
    Reference,
    Snapshot,
    read_references,
    write_reference,
)

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
FIGURES = st.dictionaries(TEXTS, st.builds(Figure, NUMBERS, st.none() | NUMBERS, TEXTS))


def reference(name="a/b", **parts):
    return Reference(
        name=name, run="run", at="../runs/b", digest_sha256="0", made_by={}, found=Snapshot(**parts)
    )


@given(figures=FIGURES, checks=st.dictionaries(TEXTS, st.booleans()))
def test_references_are_read_back_exactly(tmp_path_factory, figures, checks):
    folder = tmp_path_factory.mktemp("golden")
    written = reference(figures=figures, checks=checks)
    write_reference(folder, written)
    (stored,) = read_references(folder)
    assert stored == written
    assert {name: asdict(figure) for name, figure in stored.found.figures.items()} == {
        name: asdict(figure) for name, figure in figures.items()
    }


@given(st.binary(max_size=100))
def test_invalid_reference_is_refused(tmp_path_factory, content):
    folder = tmp_path_factory.mktemp("golden")
    (folder / REFERENCE).write_bytes(content)
    with pytest.raises(DataError, match="is not a reference of a golden run"):
        read_references(folder)


def test_empty_folder_is_refused(tmp_path):
    with pytest.raises(UsageError, match="there is no golden run"):
        read_references(tmp_path)


def test_run_path_is_relative_to_the_folder(tmp_path):
    assert reference().path(tmp_path / "golden") == tmp_path / "runs" / "b"
