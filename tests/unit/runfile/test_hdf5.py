"""Files of HDF5: how they are made, and what is said of those that are damaged or none."""

from __future__ import annotations

import os

import h5py
import pytest

from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import is_checksummed, objects, open_file
from rigrunner.runfile.hdf5 import (
    new_file,
    new_group,
    pieces_of,
    read_text,
    write_ascii,
    write_text,
    write_verbatim,
)
from unit.runfile.helpers_runfile import TWO, write_run


@pytest.mark.parametrize("read_only", [False, True])
def test_a_file_can_be_written_to_unless_it_is_made_read_only(tmp_path, read_only):
    path = tmp_path / "x.h5"
    chosen = {"read_only": True} if read_only else {}
    with new_file(path, **chosen) as file:
        file["x"] = 1.0
    assert bool(path.stat().st_mode & 0o222) is not read_only


def test_members_keep_the_order_in_which_they_were_made(tmp_path):
    with new_file(tmp_path / "x.h5") as file:
        group = new_group(file, "g", "NXcollection")
        for name in "cab":
            group[name] = 1.0
    with open_file(tmp_path / "x.h5") as file:
        assert list(file["g"]) == ["c", "a", "b"]


def test_a_file_that_does_not_begin_as_hdf5_is_described_so(tmp_path):
    path = tmp_path / "text.h5"
    path.write_text("hello, this is no HDF5 file at all")
    with pytest.raises(DataError) as caught, open_file(path):
        pass
    assert caught.value.hint.startswith("it does not start with the signature of HDF5;")


def test_a_file_that_is_cut_off_is_described_by_its_sizes(tmp_path):
    path = write_run(tmp_path / "run", TWO[:1]).seal()
    size = path.stat().st_size
    path.chmod(0o644)
    os.truncate(path, size - 1000)
    with pytest.raises(DataError) as caught, open_file(path):
        pass
    assert caught.value.hint.startswith(f"it ends after {size - 1000:,} of its {size:,} bytes;")


def test_a_file_that_begins_with_a_user_block_counts_as_one_without_checksums(tmp_path):
    """Its structure is elsewhere, so it is tried in another process first."""
    with h5py.File(tmp_path / "x.h5", "w", userblock_size=512) as file:
        file["x"] = 1.0
    assert is_checksummed(tmp_path / "x.h5") is False


def test_ctrl_c_while_a_file_is_walked_through_is_not_taken_for_damage(tmp_path, monkeypatch):
    path = write_run(tmp_path / "run", TWO[:1]).seal()

    def interrupted(*_arguments):
        raise KeyboardInterrupt

    with h5py.File(path) as file:
        monkeypatch.setattr(h5py.h5o, "open", interrupted)
        with pytest.raises(KeyboardInterrupt):
            list(objects(file))


@pytest.mark.parametrize(
    ("text", "is_attribute"),
    [("N·m", True), ("", True), ("x" * 32_000, True), ("x" * 32_001, False), ("a\0b", False)],
)
def test_a_text_is_an_attribute_unless_it_is_too_long_for_one(tmp_path, text, is_attribute):
    with new_file(tmp_path / "x.h5") as file:
        write_text(file, "text", text)
    with open_file(tmp_path / "x.h5") as file:
        assert ("text" in file.attrs) is is_attribute
        assert read_text(file, "text") == text


def test_large_texts_are_packed_and_read_back(tmp_path):
    text, column = "Set press.load to 20 N\n" * 50_000, ["main[0].sweep[0].set", "µ"] * 50_000
    with new_file(tmp_path / "x.h5") as file:
        write_verbatim(file, "text", text)
        write_ascii(file, "column", column)
        write_verbatim(file, "short", "x" * 1000)
    assert (tmp_path / "x.h5").stat().st_size < (len(text) + 20 * len(column)) / 50
    with open_file(tmp_path / "x.h5") as file:
        assert dict(objects(file)).keys() == {"column", "short", "text"}
        assert read_text(file, "text") == text
        assert file["column"][:2].tolist() == [b"main[0].sweep[0].set", rb"\xb5"]
        assert file["column"].shape == (100_000,)
        pieces = list(pieces_of(file["column"]))
        assert len(pieces) > 1
        assert [text.decode("unicode_escape") for piece in pieces for text in piece] == column
        assert file["column"].fletcher32, "damage is found"
        assert file["short"].chunks is None
