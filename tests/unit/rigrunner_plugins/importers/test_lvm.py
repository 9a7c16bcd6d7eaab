"""LVM files, as NI's Specification for the LabVIEW Measurement File (.lvm) describes them."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from rigrunner.api.errors import DataError, RigrunnerError
from rigrunner.api.importing import NotInFileError
from rigrunner_plugins.importers.lvm_file import LvmImporter
from rigrunner_plugins.importers.settings import LvmSettings
from unit.rigrunner_plugins.importers.helpers_importing import lvm_text

BOTH = {"angle": "Angle", "torque": "Torque"}
NUMBERS = {"Angle": [0.25, -1.5, 3e-7], "Torque": [-12.5, 0.0, 1e5]}


def read(tmp_path, text, columns=BOTH, group="", **settings_):
    path = tmp_path / "r.lvm"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return LvmImporter(LvmSettings(**settings_)).read(path, columns, group)


@pytest.mark.parametrize("x", ["One", "Multi", "No"])
@pytest.mark.parametrize(("sep", "mark"), [("\t", "."), ("\t", ","), (",", ".")])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_numbers_are_read_in_every_form(tmp_path, x, sep, mark, end):
    text = lvm_text([NUMBERS], x=x, sep=sep, mark=mark).replace("\n", end)
    columns = read(tmp_path, text)
    assert columns["angle"].values.tolist() == NUMBERS["Angle"]
    assert columns["torque"].values.tolist() == NUMBERS["Torque"]
    assert columns["torque"].unit == "Nm"
    assert columns["torque"].interval_s == 0.001
    assert columns["torque"].started == datetime(2026, 3, 2, 10, 15, 1, 250_000)  # noqa: DTZ001  (local time)


def test_channels_may_start_at_different_times(tmp_path):
    zero = "0.0000000000000000E+0"
    text = lvm_text([NUMBERS]).replace(f"X0\t{zero}\t{zero}", f"X0\t{zero}\t2.5E-4")
    columns = read(tmp_path, text)
    assert (columns["angle"].offset_s, columns["torque"].offset_s) == (0.0, 2.5e-4)


def test_x_values_are_a_column(tmp_path):
    columns = read(tmp_path, lvm_text([NUMBERS]), {"time": "X_Value"})
    assert columns["time"].values.tolist() == [0.0, 0.001, 0.002]
    with pytest.raises(NotInFileError, match=r"'X_Value' of 'time' is given twice"):
        read(tmp_path, lvm_text([NUMBERS], x="Multi"), {"time": "X_Value"})
    by_number = read(tmp_path, lvm_text([NUMBERS], x="Multi"), {"time": 3, "torque": 4})
    assert by_number["time"].values.tolist() == [0.0, 0.001, 0.002]
    assert by_number["torque"].values.tolist() == NUMBERS["Torque"]


def test_file_written_by_labview_is_read(tmp_path):
    """With columns of different lengths, notes, a repeated name, and a comment."""
    text = (
        "LabVIEW Measurement\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\n"
        "Decimal_Separator\t.\nMulti_Headings\tNo\nX_Columns\tOne\nTime_Pref\tAbsolute\n"
        "Operator\tuser\nDate\t2016/08/11\nTime\t14:37:48.201000213623046875\n"
        "***End_of_Header***\n\nNotes\tX values guaranteed valid only for Dev0/Ai0\n"
        "Channels\t4\nSamples\t3\t2\t0\t3\n"
        "Date\t2016/08/11\t2016/08/11\t2016/08/11\t2016/08/11\n"
        "Time\t15:37:48.375\t15:37:48.375\t15:37:48.375\t15:37:48.375\n"
        "X_Dimension\tTime\tTime\tTime\tTime\n"
        "X0\t0.0000000000000000E+0\t0.0\t0.0\t0.0\nDelta_X\t0.001000\t0.001000\t1.000000\t0.001000\n"
        "***End_of_Header***\nX_Value\tDev0/Ai0\tDev0/Ai2\tUntitled\tDev0/Ai0 1\tComment\n"
        "0.000000\t-0.011923\t7.254639\t\t-0.011923\tlook here\n"
        "0.001000\t-0.009206\t7.254639\t\t-0.009206\n"
        "0.002000\t-0.014640\t\t\t-0.014640\n"
    )
    columns = read(tmp_path, text, {"a": "Dev0/Ai0", "b": "Dev0/Ai2"})
    assert columns["a"].values.tolist() == [-0.011923, -0.009206, -0.01464]
    assert columns["b"].values.tolist() == [7.254639, 7.254639]
    assert not columns["a"].unit
    with pytest.raises(DataError, match=r"'Untitled' is empty"):
        read(tmp_path, text, {"a": "Untitled"})


def test_decimal_mark_is_a_setting_for_the_first_version(tmp_path):
    text = lvm_text([NUMBERS], mark=",").replace("Decimal_Separator\t,\n", "")
    with pytest.raises(DataError, match=r"is not a number with '\.'"):
        read(tmp_path, text)
    assert read(tmp_path, text, decimal=",")["angle"].values.tolist() == NUMBERS["Angle"]


def test_wrong_encoding_is_reported(tmp_path):
    text = lvm_text([NUMBERS], unit="\N{DEGREE SIGN}").encode("latin-1")
    for encoding in ("utf-8", "utf-16"):
        with pytest.raises(DataError, match=f"is not {encoding}"):
            read(tmp_path, text, encoding=encoding)
    assert read(tmp_path, text, encoding="latin-1")["angle"].unit == "\N{DEGREE SIGN}"


def test_special_blocks_are_skipped(tmp_path):
    block = "***Start_Special***\t\nSamples\t9\t9\n1\t2\t3\n***End_Special***\t\n"
    text = lvm_text([NUMBERS, NUMBERS])
    for at in ("X0", "X_Value", "\t\nChannels"):
        assert read(tmp_path, text.replace(at, block + at), group="2")["angle"].unit == "Nm"


def test_segments_are_selected_by_number(tmp_path):
    text = lvm_text([NUMBERS, {"Angle": [7.0, 8.0], "Torque": [1.0, 2.0]}])
    assert read(tmp_path, text, group="2")["angle"].values.tolist() == [7.0, 8.0]
    assert read(tmp_path, text, group="1")["angle"].values.tolist() == NUMBERS["Angle"]
    for group, words in {"": "no segment is named", "3": "there is no segment 3"}.items():
        with pytest.raises(NotInFileError, match=words) as raised:
            read(tmp_path, text, group=group)
        assert raised.value.hint.startswith("there are 2: give one as 'group', from 1 to 2, or")
    for group in ("two", "0", "2-1", "1-", "1-2-3"):
        with pytest.raises(NotInFileError, match=f"'{group}' names no segments"):
            read(tmp_path, text, group=group)


def test_consecutive_segments_are_joined(tmp_path):
    segments = [lvm_text([NUMBERS]), lvm_text([{"Angle": [7.0], "Torque": [1.0]}])]
    second = segments[1].split("***End_of_Header***", 1)[1].replace("10:15:01.25", "10:15:01.253")
    text = segments[0] + second.lstrip("\t\n").join(["\n", ""])
    for group in ("1-2", "all"):
        columns = read(tmp_path, text, group=group)
        assert columns["angle"].values.tolist() == [*NUMBERS["Angle"], 7.0]
        start = datetime(2026, 3, 2, 10, 15, 1, 253_000)  # noqa: DTZ001  (local time)
        assert columns["angle"].goes == ((3, start),)
    assert read(tmp_path, text, group="2")["angle"].goes == ()
    with pytest.raises(DataError, match="segment 2 of 'angle' has another unit or interval"):
        read(tmp_path, text.replace("Nm", "rad", 2), group="all")
    with pytest.raises(DataError, match="does not say when each segment began"):
        read(tmp_path, text.replace("Time\t10", "Zeit\t10"), group="all")
    with pytest.raises(NotInFileError, match="there is no segment 3"):
        read(tmp_path, text, group="1-3")


def test_repeated_writes_of_one_segment_need_x_values(tmp_path):
    text = lvm_text([NUMBERS], many=False) + "0.003\t1\t2\n"
    with pytest.raises(DataError, match="has 4 samples, its header says 3") as raised:
        read(tmp_path, text)
    assert "gaps can be detected only in X values" in raised.value.hint
    columns = read(tmp_path, text, {**BOTH, "time": "X_Value"})
    assert columns["time"].values.tolist() == [0.0, 0.001, 0.002, 0.003]


@pytest.mark.parametrize(
    ("delta", "within_s"),
    [("0.000100", 5e-7), ("2.000000E-6", 5e-13), ("1.0E-4", 5e-6), ("0.1", 0.05)],
)
def test_interval_tolerance_is_half_of_its_last_digit(tmp_path, delta, within_s):
    text = lvm_text([NUMBERS], delta=delta)
    assert read(tmp_path, text)["angle"].interval_within_s == pytest.approx(within_s)


ROWS = lvm_text([NUMBERS])
LAST = "0.002000\t3e-07\t100000.0"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is not an LVM file with a header"),
        ("time,torque\n0,1\n", "is not an LVM file with a header"),
        (ROWS.split("***End", maxsplit=1)[0], "the header of the file has no end"),
        (ROWS.rsplit("***End", maxsplit=1)[0], "the header of a segment has no end"),
        (ROWS.split("X_Value", maxsplit=1)[0], "the names of the columns are not there"),
        (ROWS.split("\t\nChannels", maxsplit=1)[0], "the file has no segment"),
        (ROWS.replace(LAST, ""), "has 2 samples, its header says 3"),
        (ROWS.replace("-1.5", ""), ":26: 'Angle' continues after an empty cell"),
        (ROWS.replace("-1.5", "NaN"), ":25: 'NaN' is not a number"),
        (ROWS.replace("-1.5", "1,5"), ":25: '1,5' is not a number with '.' as decimal mark"),
        (ROWS.replace("\tTorque", "\tMoment"), "the column 'Torque' of 'torque' is not there"),
        (ROWS.encode("utf-16"), "is not utf-8"),
        (ROWS.replace("Separator\t.", "Separator\t\t"), None),
    ],
)
def test_invalid_files_are_reported_with_their_line(tmp_path, text, words):
    if words is None:
        assert read(tmp_path, text)
        return
    with pytest.raises(DataError) as raised:
        read(tmp_path, text)
    assert words in str(raised.value)
    assert "r.lvm" in str(raised.value)


@settings(deadline=None, max_examples=examples(150))
@given(cuts=st.lists(st.tuples(st.integers(0, len(ROWS)), st.text(max_size=4)), max_size=4))
def test_damaged_file_is_read_or_refused(tmp_path_factory, cuts):
    text = ROWS
    for at, inserted in cuts:
        text = text[:at] + inserted + text[at + len(inserted) :]
    path = Path(tmp_path_factory.getbasetemp()) / "damaged.lvm"
    path.write_text(text, encoding="utf-8")
    try:
        LvmImporter(LvmSettings()).read(path, BOTH, "")
    except RigrunnerError:
        return
