"""The file that HDF5 writes to, which never fails: as any other file, until an error is kept."""

from __future__ import annotations

import os

import pytest

from rigrunner.runfile.patient_file import PatientFile


@pytest.fixture
def file(tmp_path):
    with PatientFile(tmp_path / "a") as opened:
        yield opened


class Full:
    """A file on a disk without room; only the first error is to be kept."""

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


def test_it_knows_its_size_and_where_it_stands(file):
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


def test_what_cannot_be_written_is_dropped_and_the_first_error_kept(file):
    file.write(b"abc")
    file._file.close()
    file._file = Full()
    assert file.write(b"defg") == 4
    assert file.truncate(2) == 2
    assert file.error.errno == 28
    assert file.seek(0, os.SEEK_END) == 2
    file.seek(0)
    assert file.read(3) == bytes(3)


def test_an_error_of_truncating_is_kept_as_well(file):
    file._file.close()
    file._file = Full()
    file.truncate(7)
    assert file.error.errno == 28


def test_it_is_read_as_well_as_written_until_it_is_closed(tmp_path):
    file = PatientFile(tmp_path / "a")
    assert file.readable()
    file.write(b"abcde")
    file.seek(1)
    assert (file.read(2), file.read(1), file.tell()) == (b"bc", b"d", 4)
    file.close()
    assert file.closed
    file.close()
