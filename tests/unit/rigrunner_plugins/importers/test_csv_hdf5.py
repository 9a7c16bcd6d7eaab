"""What importing adds to the CSV and HDF5 that the replay reads: units, groups, similar names."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner.api.hooks import NoSettings
from rigrunner.api.importing import NotInFileError
from rigrunner_plugins.importers.csv_file import CsvImporter
from rigrunner_plugins.importers.hdf5_file import Hdf5Importer
from rigrunner_plugins.importers.settings import TableSettings


def csv(tmp_path, text, columns, group="", **table):
    (tmp_path / "a.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    return CsvImporter(TableSettings(**table)).read(tmp_path / "a.csv", columns, group)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("Torque (Nm)", "Nm"),
        ("Torque [mN.m]", "mN.m"),
        ("Torque / mN·m", "mN·m"),
        ("k / W/(m·K)", "W/(m·K)"),
        ("raw / filtered (N)", "N"),
        ("raw / filtered", ""),
        ("Torque (raw)", ""),
        ("Torque Nm", ""),
        ("Torque (N·m) 1", ""),
    ],
)
def test_unit_at_the_end_of_a_column_name_is_read(tmp_path, name, unit):
    columns = csv(tmp_path, f"{name},b\n1,2\n", {"x": name})
    assert columns["x"].unit == unit


def test_missing_column_suggests_a_similar_name(tmp_path):
    with pytest.raises(NotInFileError) as raised:
        csv(tmp_path, "Torque (Nm),Angle\n1,2\n", {"x": "torque (Nm)"})
    assert raised.value.hint == "did you mean 'Torque (Nm)'?"
    assert raised.value.wanted == "x"
    with pytest.raises(NotInFileError, match="there is no column 3"):
        csv(tmp_path, "a,b\n1,2\n", {"x": 3})
    with pytest.raises(NotInFileError, match="the file names no columns"):
        csv(tmp_path, "1,2\n", {"x": "a"}, header=False)
    with pytest.raises(NotInFileError, match="a CSV file has no groups"):
        csv(tmp_path, "a,b\n1,2\n", {"x": "a"}, group="g")


def test_csv_without_rows_is_refused(tmp_path):
    for text in ("a,b\n", ""):
        with pytest.raises(DataError):
            csv(tmp_path, text, {"x": "a"})


@pytest.mark.parametrize(
    ("text", "header"),
    [
        ("time,torque\n0,1\n1,2,5\n", True),  # a decimal comma
        ("time,torque\n0,1\n1,1,234.5\n", True),  # thousands
        ("0,1\n1,2,5\n", False),
        ("0,1,234.5\n1,1,235.5\n", False),  # in every row
    ],
)
def test_delimiter_within_a_number_is_refused(tmp_path, text, header):
    with pytest.raises(DataError, match=r"has 3 columns, (the header has|expected) 2"):
        csv(tmp_path, text, {"x": 2}, header=header)


def test_number_of_columns_must_be_stated_without_a_header(tmp_path):
    text = "0,1,234.5\n1,1,235.5\n"
    with pytest.raises(DataError) as raised:
        csv(tmp_path, text, {"x": 2}, header=False)
    assert raised.value.hint.endswith("if not, state 'columns: 3' in the settings")
    settings = TableSettings(header=False, columns=3)
    columns = CsvImporter(settings).read(tmp_path / "a.csv", {"x": 2}, "")
    assert columns["x"].values.tolist() == [1.0, 1.0]
    settings = TableSettings(header=False, columns=2)
    with pytest.raises(DataError, match="has 3 columns, expected 2"):
        CsvImporter(settings).read(tmp_path / "a.csv", {"x": 1}, "")


def test_trailing_delimiter_is_permitted(tmp_path):
    columns = csv(tmp_path, "time,torque\n0,1.5,\n1,2.5, \n", {"x": "torque"})
    assert columns["x"].values.tolist() == [1.5, 2.5]


def test_line_number_is_that_of_the_file_despite_multi_line_cells(tmp_path):
    with pytest.raises(DataError, match=r"a\.csv:6: 'bad' is not a number"):
        csv(tmp_path, 'by hand\n"torque\n(N·m)",note\n1,"a\nb"\nbad,c\n', {"x": 1}, skip_lines=1)


def test_wrong_encoding_is_reported(tmp_path):
    for encoding in ("utf-8", "utf-16"):
        with pytest.raises(DataError, match=f"is not {encoding}"):
            csv(tmp_path, "\N{DEGREE SIGN},b\n1,2\n".encode("latin-1"), {"x": 1}, encoding=encoding)


def test_hdf5_units_are_read_and_missing_names_suggested(tmp_path):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["g/x"] = np.arange(3.0)
        file["g/x"].attrs["units"] = "Nm"
        file["g/y"] = np.arange(3)
        file["g/y"].attrs["unit"] = np.bytes_("deg")
        file["g/z"] = np.array([1.0, np.inf])
        file["g/c"] = np.array([1.0j])
    columns = Hdf5Importer(NoSettings()).read(path, {"x": "x", "y": "y"}, "g")
    assert (columns["x"].unit, columns["y"].unit) == ("Nm", "deg")
    assert columns["y"].values.tolist() == [0.0, 1.0, 2.0]
    for column, group, words in (
        ("X", "g", "did you mean 'x'"),
        ("x", "G", "there is no group 'G'"),
        ("z", "g", "not finite at sample 2"),
        ("c", "g", "not a list of numbers"),
    ):
        with pytest.raises(DataError, match=words):
            Hdf5Importer(NoSettings()).read(path, {"x": column}, group)


@pytest.mark.parametrize(
    ("name", "unit"),
    [("units", np.array([b"mN.m"])), ("unit", np.array(["mN.m"], dtype=object)), ("Units", "mN.m")],
)
def test_unit_of_an_hdf5_dataset_is_read_in_other_spellings(tmp_path, name, unit):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["x"] = np.arange(3.0)
        file["x"].attrs[name] = unit
    columns = Hdf5Importer(NoSettings()).read(tmp_path / "a.h5", {"x": "x"}, "")
    assert columns["x"].unit == "mN.m"


@pytest.mark.parametrize("name", ["scale_factor", "add_offset"])
def test_packed_hdf5_dataset_is_refused(tmp_path, name):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["x"] = np.arange(3, dtype=np.int16)
        file["x"].attrs[name] = 0.01
    with pytest.raises(DataError, match=f"'/x' is packed, which is not read.* {name}"):
        Hdf5Importer(NoSettings()).read(tmp_path / "a.h5", {"x": "x"}, "")


@pytest.mark.parametrize("name", ["_FillValue", "missing_value"])
def test_fill_value_of_hdf5_is_refused_as_a_sample(tmp_path, name):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for dataset, values in (("x", [1.0, -9999.0]), ("y", [1.0, 2.0])):
            file[dataset] = values
            file[dataset].attrs[name] = -9999.0
    importer = Hdf5Importer(NoSettings())
    with pytest.raises(DataError, match=f"'/x' has missing values: -9999.0, its {name}"):
        importer.read(tmp_path / "a.h5", {"x": "x"}, "")
    assert importer.read(tmp_path / "a.h5", {"y": "y"}, "")["y"].values.tolist() == [1.0, 2.0]
