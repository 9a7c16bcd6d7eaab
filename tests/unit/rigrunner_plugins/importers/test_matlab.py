"""MATLAB files: version 5 written by scipy, version 7.3 as MATLAB writes it, by h5py."""

from __future__ import annotations

from struct import pack
from zlib import compress

import numpy as np
import pytest
from scipy.io import savemat
from scipy.sparse import csc_array

from rigrunner.api.errors import DataError
from rigrunner.api.hooks import NoSettings
from rigrunner.api.importing import NotInFileError
from rigrunner_plugins.importers.matlab_file import MatlabImporter
from unit.rigrunner_plugins.importers.helpers_importing import write_matlab_73

X = np.array([1.0, -2.5, 1e-9])
MATRIX = np.array([[1.0, 10.0], [2.0, 20.0], [3.0, 30.0]])
CONTENT = {
    "row": X.reshape(1, -1),
    "column": X.reshape(-1, 1),
    "matrix": MATRIX,
    "counts": np.array([[1, 2, 3]], np.int16),
    "run": {"torque": X.reshape(-1, 1), "data": MATRIX, "inner": {"x": X.reshape(1, -1)}},
    "cplx": np.array([[1 + 2j, 3.0]]),
    "cells": np.array([[1.0, "a"]], object),
    "words": "text",
    "flags": np.array([[True, False]]),
    "hollow": np.empty((0, 0)),
    "gap": np.array([[1.0, np.nan, 2.0]]),
    "cube": np.zeros((2, 2, 2)),
    "few": csc_array(np.eye(3)),
}


@pytest.fixture(scope="module", params=["5", "5 compressed", "7.3"])
def path(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("matlab") / "a.mat"
    if request.param == "7.3":
        write_matlab_73(path, CONTENT)
    else:
        savemat(path, CONTENT, do_compression="compressed" in request.param)
    return path


def read(path, column, group=""):
    return (
        MatlabImporter(NoSettings()).read(path, {"torque": column}, group)["torque"].values.tolist()
    )


@pytest.mark.parametrize(
    ("column", "group", "expected"),
    [
        ("row", "", X),
        ("column", "", X),
        ("matrix(:,2)", "", MATRIX[:, 1]),
        ("matrix(:, 1)", "", MATRIX[:, 0]),
        ("counts", "", [1.0, 2.0, 3.0]),
        ("flags", "", [1.0, 0.0]),
        ("run.torque", "", X),
        ("torque", "run", X),
        ("data(:,2)", "run", MATRIX[:, 1]),
        ("x", "run.inner", X),
    ],
)
def test_vectors_and_columns_are_read(path, column, group, expected):
    assert read(path, column, group) == list(expected)


@pytest.mark.parametrize(
    ("column", "words"),
    [
        ("Row", "'Row' of 'torque' is not there (did you mean 'row'"),
        ("run.tork", "'run.tork' of 'torque' is not there (did you mean 'torque'?)"),
        ("row.x", "'row.x' of 'torque' is not there"),
        ("matrix(2,:)", "names nothing in a MATLAB file"),
        ("matrix(:,3)", "the matrix has 2 columns"),
        ("matrix", "is a matrix of 3 x 2 (say which of its columns: matrix(:,1))"),
        ("run", "'run' is a structure, not numbers"),
        ("cells", "'cells' is a cell array, not numbers"),
        ("words", "'words' is text, not numbers"),
        ("few", "not numbers"),
        ("cplx", "complex"),
        ("hollow", "'hollow' is empty"),
        ("gap", "'gap' is not finite at sample 2 (nan)"),
        ("cube", "'cube' has 3 dimensions"),
        (3, "'3' of 'torque' names nothing"),
    ],
)
def test_variable_that_is_no_recording_is_refused(path, column, words):
    with pytest.raises(DataError) as raised:
        read(path, column)
    assert words in str(raised.value)


def test_repeated_variable_is_refused(tmp_path):
    original, path = tmp_path / "one.mat", tmp_path / "two.mat"
    savemat(original, {"x": X})
    path.write_bytes(original.read_bytes() + original.read_bytes()[128:])
    with pytest.raises(DataError, match="the variable 'x' is given twice"):
        read(path, "x")


def test_other_files_are_refused(tmp_path):
    path = tmp_path / "a.mat"
    for content in (b"", b"no\n", b"MATLAB 5.0 MAT-file".ljust(128) + b"\xff" * 64):
        path.write_bytes(content)
        with pytest.raises(DataError, match="MATLAB file, or is damaged"):
            read(path, "x")
    with pytest.raises(DataError, match="No such file"):
        read(tmp_path / "none.mat", "x")


def test_truncated_file_is_refused(tmp_path):
    original, path = tmp_path / "whole.mat", tmp_path / "cut.mat"
    savemat(original, {"x": np.arange(300.0)}, do_compression=True)
    content = original.read_bytes()
    for length in range(0, len(content), 7):
        path.write_bytes(content[:length])
        with pytest.raises((DataError, NotInFileError)):
            read(path, "x")


@pytest.mark.parametrize("count", [3, 2**27 + 1])
def test_list_of_structures_is_refused_without_reading_its_elements(tmp_path, count):
    """A damaged size, the second number of the dimensions, once made reading endless."""
    path = tmp_path / "list.mat"
    structures = np.zeros((1, 3), [("x", object)])
    savemat(path, {"s": structures})
    content = path.read_bytes()
    at = content.index((1).to_bytes(4, "little") + (3).to_bytes(4, "little"))
    path.write_bytes(content[: at + 4] + count.to_bytes(4, "little") + content[at + 8 :])

    with pytest.raises(DataError, match="list of structures"):
        MatlabImporter(NoSettings()).read(path, {"torque": "s"}, "")


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize(("wide", "high"), [(2**15, 2**15), (2**31 - 1, 1), (-1, 1)])
@pytest.mark.parametrize("inner", [{"x": X}, np.array([["a"]], object)], ids=["structure", "cell"])
def test_nested_list_of_damaged_size_is_refused_unread(tmp_path, inner, wide, high, compressed):
    """Reading it was endless: scipy makes all elements, whether or not the data are there."""
    path, dimensions = tmp_path / "nested.mat", pack("<IIii", 5, 8, 1, 1)
    savemat(path, {"s": {"inner": inner, "x": X}})
    content = path.read_bytes()
    at = content.index(dimensions, content.index(dimensions) + 1)
    content = content[:at] + pack("<IIii", 5, 8, wide, high) + content[at + 16 :]
    if compressed:
        packed = compress(content[128:])
        content = content[:128] + pack("<II", 15, len(packed)) + packed
    path.write_bytes(content)
    with pytest.raises(DataError, match=r"damaged: a list in it has .* elements in \d+ bytes"):
        read(path, "s.x")


def test_nested_lists_of_any_content_are_skipped(tmp_path):
    structures = np.zeros((1, 300), [("x", object)])
    path = tmp_path / "nested.mat"
    nested = {"list": structures, "cells": np.array([[1.0, "a"]], object)}
    savemat(path, {"s": {**nested, "x": X}})
    assert read(path, "s.x") == X.tolist()
