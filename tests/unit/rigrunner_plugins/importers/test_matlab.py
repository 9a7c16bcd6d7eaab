"""MATLAB files: version 5 written by scipy, version 7.3 as MATLAB writes it, by h5py."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from scipy.io import savemat
from scipy.sparse import csc_array

from rigrunner.api.errors import DataError
from rigrunner.api.importing import NotInFileError
from rigrunner_plugins.importers.matlab_file import MatlabImporter

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


def write_73(path, content):
    """Write as MATLAB does with -v7.3: transposed, its class in an attribute, 512 bytes before."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in content.items():
            put(file, name, value)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def put(group, name, value):
    if isinstance(value, dict):
        made, kind = group.create_group(name), "struct"
        for field, inner in value.items():
            put(made, field, inner)
    elif isinstance(value, str):
        made, kind = group.create_dataset(name, data=np.frombuffer(value.encode(), "u1")), "char"
    elif hasattr(value, "tocsc"):
        made, kind = group.create_group(name), "double"
        made.create_dataset("data", data=value.data)
        made.attrs["MATLAB_sparse"] = np.uint64(3)
    elif value.dtype == object:
        made = group.create_dataset(name, (2, 1), h5py.ref_dtype)
        kind = "cell"
    elif value.size == 0:
        made, kind = group.create_dataset(name, data=np.zeros(2, "u8")), "double"
        made.attrs["MATLAB_empty"] = np.uint8(1)
    elif np.iscomplexobj(value):
        pairs = np.zeros(value.T.shape, [("real", "f8"), ("imag", "f8")])
        pairs["real"], pairs["imag"] = value.T.real, value.T.imag
        made, kind = group.create_dataset(name, data=pairs), "double"
    else:
        flags = value.dtype == bool
        data = value.T.astype("u1") if flags else value.T
        made = group.create_dataset(name, data=data)
        kind = "logical" if flags else {"f": "double", "i": "int16"}[value.dtype.kind]
    made.attrs["MATLAB_class"] = np.bytes_(kind)


@pytest.fixture(scope="module", params=["5", "5 compressed", "7.3"])
def path(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("matlab") / "a.mat"
    if request.param == "7.3":
        write_73(path, CONTENT)
    else:
        savemat(path, CONTENT, do_compression="compressed" in request.param)
    return path


def read(path, column, group=""):
    return MatlabImporter().read(path, {"torque": column}, group)["torque"].values.tolist()


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
def test_vectors_and_columns_are_found(path, column, group, expected):
    assert read(path, column, group) == list(expected)


@pytest.mark.parametrize(
    ("column", "told"),
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
def test_what_is_no_recording_is_told(path, column, told):
    with pytest.raises(DataError) as caught:
        read(path, column)
    assert told in str(caught.value)


def test_a_variable_that_is_there_twice_is_refused(tmp_path):
    one, path = tmp_path / "one.mat", tmp_path / "two.mat"
    savemat(one, {"x": X})
    path.write_bytes(one.read_bytes() + one.read_bytes()[128:])
    with pytest.raises(DataError, match="the variable 'x' is there twice"):
        read(path, "x")


def test_other_files_are_refused(tmp_path):
    path = tmp_path / "a.mat"
    for content in (b"", b"no\n", b"MATLAB 5.0 MAT-file".ljust(128) + b"\xff" * 64):
        path.write_bytes(content)
        with pytest.raises(DataError, match="MATLAB file, or is damaged"):
            read(path, "x")
    with pytest.raises(DataError, match="No such file"):
        read(tmp_path / "none.mat", "x")


def test_a_cut_file_is_refused(tmp_path):
    whole, path = tmp_path / "whole.mat", tmp_path / "cut.mat"
    savemat(whole, {"x": np.arange(300.0)}, do_compression=True)
    content = whole.read_bytes()
    for length in range(0, len(content), 7):
        path.write_bytes(content[:length])
        with pytest.raises((DataError, NotInFileError)):
            read(path, "x")
