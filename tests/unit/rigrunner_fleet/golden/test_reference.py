"""References on disk: what was written is read, and what is none is refused with its place."""

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


def reference(name="a/b", **found):
    return Reference(
        name=name, run="run", at="../runs/b", digest_sha256="0", made_by={}, found=Snapshot(**found)
    )


@given(figures=FIGURES, checks=st.dictionaries(TEXTS, st.booleans()))
def test_what_was_written_is_read_bit_by_bit(tmp_path_factory, figures, checks):
    folder = tmp_path_factory.mktemp("golden")
    written = reference(figures=figures, checks=checks)
    write_reference(folder, written)
    (stored,) = read_references(folder)
    assert stored == written
    assert {name: asdict(figure) for name, figure in stored.found.figures.items()} == {
        name: asdict(figure) for name, figure in figures.items()
    }


@given(st.binary(max_size=100))
def test_what_is_none_is_refused(tmp_path_factory, content):
    folder = tmp_path_factory.mktemp("golden")
    (folder / REFERENCE).write_bytes(content)
    with pytest.raises(DataError, match="is not a reference of a golden run"):
        read_references(folder)


def test_an_empty_folder_has_no_golden_run(tmp_path):
    with pytest.raises(UsageError, match="there is no golden run"):
        read_references(tmp_path)


def test_the_run_is_found_from_the_folder(tmp_path):
    assert reference().path(tmp_path / "golden") == tmp_path / "runs" / "b"
