"""The file that HDF5 writes to: like any file, but it keeps the first error instead of raising."""

from __future__ import annotations

import os

import pytest

from rigrunner.runfile.patient_file import PatientFile


@pytest.fixture
def file(tmp_path):
    with PatientFile(tmp_path / "a") as opened:
        yield opened


class FullDiskFile:
    """A file on a full disk; only the first error must be kept."""

    closed = False

    def __init__(self):
        self.errors = [OSError(28, "No space left on device"), OSError(5, "later")]

    def seek(self, _position):
        """Go anywhere."""

    def write(self, _data):
        raise self.errors.pop(0)

    truncate = write

    def close(self):
        """Nothing is held."""


def test_size_and_position_are_tracked(file):
    assert file.write(b"abcde") == 5
    assert file.tell() == 5
    assert file.seek(1) == 1
    file.write(b"XY")
    assert file.seek(0, os.SEEK_END) == 5
    assert file.seek(-2, os.SEEK_END) == 3
    assert file.seek(-1, os.SEEK_CUR) == 2
    assert file.truncate() == 2
    assert file.seek(0, os.SEEK_END) == 2
    assert file.truncate(4) == 4
    assert file.seek(0, os.SEEK_END) == 4
    file.seek(0)
    assert file.read(9) == b"aX\0\0" + bytes(5)
    assert file.error is None


def test_failed_write_is_dropped_and_its_first_error_kept(file):
    file.write(b"abc")
    file._file.close()
    file._file = FullDiskFile()
    assert file.write(b"defg") == 4
    assert file.truncate(2) == 2
    assert file.error.errno == 28
    assert file.seek(0, os.SEEK_END) == 2
    file.seek(0)
    assert file.read(3) == bytes(3)


def test_error_of_truncate_is_kept(file):
    file._file.close()
    file._file = FullDiskFile()
    file.truncate(7)
    assert file.error.errno == 28


def test_file_can_be_read_until_closed(tmp_path):
    file = PatientFile(tmp_path / "a")
    assert file.readable()
    file.write(b"abcde")
    file.seek(1)
    assert (file.read(2), file.read(1), file.tell()) == (b"bc", b"d", 4)
    file.close()
    assert file.closed
    file.close()
