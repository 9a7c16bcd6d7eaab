from __future__ import annotations

import h5py
import pytest

from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import is_checksummed, walk
from rigrunner.runfile import (
    file_differences,
    probe,
    read,
    read_info,
    read_summary,
    read_truth,
    read_with_truth,
    refuse_crashing,
)
from unit.runfile.helpers_runfile import TWO, write_run


def test_a_run_and_what_is_none_are_left_to_the_reader(tmp_path):
    refuse_crashing(write_run(tmp_path / "run", TWO).seal())
    (tmp_path / "text.h5").write_text("hello")
    refuse_crashing(tmp_path / "text.h5")


@pytest.mark.parametrize(
    ("child", "message"),
    [
        (
            "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)",
            r"crashes on it \(exit code -11",
        ),
        ("while True: pass", "does not end"),
    ],
)
def test_what_would_take_this_process_along_is_told(tmp_path, monkeypatch, child, message):
    (tmp_path / "x.h5").write_bytes(b"")
    monkeypatch.setattr(probe, "_CHILD", child)
    monkeypatch.setattr(probe, "_LEAST_S", 1.0)
    with pytest.raises(DataError, match=message):
        refuse_crashing(tmp_path / "x.h5")


READERS = [read, read_info, read_summary, read_truth, read_with_truth, file_differences]


def old_layout(path):
    with h5py.File(path, "w", libver="earliest") as file:
        file.attrs["rigrunner_format"] = 2
        file.create_group("entry")
    return path


def test_what_we_write_has_a_structure_with_checksums(tmp_path):
    assert is_checksummed(write_run(tmp_path / "run", TWO).seal()) is True
    assert is_checksummed(old_layout(tmp_path / "old.h5")) is False
    (tmp_path / "text.h5").write_text("hello")
    assert is_checksummed(tmp_path / "text.h5") is None
    assert is_checksummed(tmp_path) is None


@pytest.mark.parametrize("reader", READERS)
def test_every_reader_tries_a_file_without_checksums_elsewhere_first(tmp_path, monkeypatch, reader):
    monkeypatch.setattr(probe, "_CHILD", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    with pytest.raises(DataError, match="the HDF5 library crashes on it"):
        reader(old_layout(tmp_path / "old.h5"))


@pytest.mark.parametrize("reader", READERS)
def test_no_reader_waits_for_ever_for_a_file_without_checksums(tmp_path, monkeypatch, reader):
    monkeypatch.setattr(probe, "_CHILD", "while True: pass")
    monkeypatch.setattr(probe, "_LEAST_S", 0.2)
    with pytest.raises(DataError, match="the HDF5 library does not end"):
        reader(old_layout(tmp_path / "old.h5"))


def test_a_damaged_byte_of_the_structure_is_told_by_its_checksum(tmp_path):
    path = write_run(tmp_path / "run", TWO).seal()
    data = bytearray(path.read_bytes())
    at = data.index(b"OHDR") + 12  # in an object header of version 2, which a checksum follows
    data[at] ^= 0xFF
    damaged = tmp_path / "damaged.h5"
    damaged.write_bytes(data)
    with pytest.raises(DataError, match=r"cannot be read|damaged"):
        read(damaged)


def test_the_child_reads_attributes_and_data_of_all_there_is(tmp_path):
    sealed = write_run(tmp_path / "run", TWO).seal()
    walk(sealed)
    (tmp_path / "text.h5").write_text("hello")
    walk(tmp_path / "text.h5")


def test_a_module_beside_a_strangers_file_is_not_imported(tmp_path, monkeypatch):
    old_layout(tmp_path / "old.h5")
    (tmp_path / "h5py.py").write_text("open('was_imported', 'w')")
    monkeypatch.chdir(tmp_path)
    refuse_crashing(tmp_path / "old.h5")
    assert not (tmp_path / "was_imported").exists()


def test_the_child_reads_the_data_of_every_dataset(tmp_path, monkeypatch):
    sealed = write_run(tmp_path / "run", TWO).seal()
    with h5py.File(sealed) as file:
        expected = set()
        file.visititems(
            lambda name, item: expected.add(f"/{name}") if isinstance(item, h5py.Dataset) else None
        )
    names, read_part = set(), h5py.Dataset.__getitem__

    def noted(dataset, *arguments, **more):
        names.add(dataset.name)
        return read_part(dataset, *arguments, **more)

    monkeypatch.setattr(h5py.Dataset, "__getitem__", noted)
    walk(sealed)
    assert names == expected
    assert f"/entry/recordings/_{TWO[1].name}/tester_torque" in names
