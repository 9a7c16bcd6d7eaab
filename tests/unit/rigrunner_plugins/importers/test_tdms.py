"""TDMS files, written by npTDMS."""

from __future__ import annotations

import sys
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from rigrunner.api.errors import DataError, MissingPackageError
from rigrunner.api.hooks import NoSettings
from rigrunner.api.importing import NotInFileError
from rigrunner.registry import load_registry
from rigrunner.tools.importing.sampling import start_of
from rigrunner_plugins.importers.tdms_file import TdmsImporter

START = np.datetime64("2026-03-02T09:15:00.25", "us")
WAVE = {"wf_increment": 1e-4, "wf_start_offset": 0.5, "wf_start_time": START, "unit_string": "Nm"}
TORQUE = np.array([1.0, -2.5, 1e-9])


def write(path, *channels, parts=1):
    groups = [GroupObject(name) for name in dict.fromkeys(c.group for c in channels)]
    with TdmsWriter(path) as writer:
        for _ in range(parts):
            writer.write_segment([RootObject(), *groups, *channels])
    return path


def torque(group="r1", data=TORQUE, name="Torque", **properties):
    return ChannelObject(group, name, data, properties=properties or WAVE)


def read(path, columns=None, group=""):
    return TdmsImporter(NoSettings()).read(path, columns or {"torque": "Torque"}, group)["torque"]


def test_samples_have_unit_interval_and_start(tmp_path):
    column = read(write(tmp_path / "a.tdms", torque()))
    assert column.values.tolist() == TORQUE.tolist()
    assert (column.unit, column.interval_s, column.interval_within_s) == ("Nm", 1e-4, 0.0)
    assert column.offset_s == 0.5
    assert column.started == datetime(2026, 3, 2, 9, 15, 0, 250_000, tzinfo=UTC)


def test_segments_of_a_channel_are_joined(tmp_path):
    path = write(tmp_path / "a.tdms", torque(), torque(name="Other"), parts=3)
    assert read(path).values.tolist() == TORQUE.tolist() * 3


def test_scaled_integers_are_read_as_in_labview(tmp_path):
    scale = {
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": 0.5,
        "NI_Scale[0]_Linear_Y_Intercept": 10.0,
        "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
    }
    path = write(tmp_path / "a.tdms", torque(data=np.array([0, 2, -4], np.int16), **scale))
    assert read(path).values.tolist() == [10.0, 11.0, 8.0]


def test_group_must_be_named_if_there_are_several(tmp_path):
    path = write(tmp_path / "a.tdms", torque("r1"), torque("r2", TORQUE + 1))
    assert read(path, group="r2").values.tolist() == (TORQUE + 1).tolist()
    with pytest.raises(NotInFileError, match=r"no group is named.*groups: r1, r2"):
        read(path)
    with pytest.raises(NotInFileError, match=r"no group 'R2'.*did you mean 'r2'"):
        read(path, group="R2")


def test_index_file_of_another_file_is_ignored(tmp_path):
    path = write(tmp_path / "a.tdms", torque())
    write(tmp_path / "b.tdms", torque(data=np.zeros(7)))
    (tmp_path / "b.tdms_index").rename(tmp_path / "a.tdms_index") if (
        tmp_path / "b.tdms_index"
    ).exists() else (tmp_path / "a.tdms_index").write_bytes(b"TDSh of another")
    assert read(path).values.tolist() == TORQUE.tolist()


@pytest.mark.parametrize(
    ("channel", "words"),
    [
        (torque(name="Moment"), "the channel 'r1/Torque' of 'torque' is not there"),
        (torque(data=np.array([1.0, np.nan, 2.0])), "is not finite at sample 2 (nan)"),
        (torque(data=np.array([1 + 2j, 3j])), "has complex numbers"),
        (torque(data=["a", "b"]), "is not a list of numbers"),
        (torque(data=np.array([START, START])), "is not a list of numbers"),
        (torque(data=np.array([], np.float64)), "is empty"),
    ],
)
def test_channel_that_is_no_recording_is_refused(tmp_path, channel, words):
    path = write(tmp_path / "a.tdms", channel)
    with pytest.raises(DataError) as raised:
        read(path)
    assert words in str(raised.value)
    assert "a.tdms" in str(raised.value)


def test_truncated_file_is_refused_at_every_length(tmp_path):
    content = write(tmp_path / "a.tdms", torque(data=np.arange(50.0))).read_bytes()
    path = tmp_path / "cut.tdms"
    for length in range(len(content)):
        path.write_bytes(content[:length])
        with pytest.raises(DataError):
            read(path)


def test_recording_continued_in_a_truncated_segment_is_refused(tmp_path, capsys):
    content = write(tmp_path / "a.tdms", torque(data=np.arange(50.0)), parts=2).read_bytes()
    second = content.index(b"TDSm", 4)
    path = tmp_path / "cut.tdms"
    for length in (*range(second + 1, len(content), 3), len(content) - 1):
        path.write_bytes(content[:length])
        with pytest.raises(DataError):
            read(path)
    assert capsys.readouterr() == ("", "")
    path.write_bytes(content[:second])
    assert len(read(path).values) == 50


def test_truncated_file_still_gives_its_complete_channels(tmp_path):
    path = write(tmp_path / "a.tdms", torque("r1"))
    with TdmsWriter(path, mode="a") as writer:
        writer.write_segment([GroupObject("r2"), torque("r2", np.arange(100.0))])
    path.write_bytes(path.read_bytes()[:-80])
    assert read(path, group="r1").values.tolist() == TORQUE.tolist()
    with pytest.raises(DataError, match=r"'r2/Torque' is cut short"):
        read(path, group="r2")


def test_missing_package_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "nptdms", None)
    monkeypatch.delitem(sys.modules, "rigrunner_plugins.importers.tdms_file", raising=False)
    with pytest.raises(MissingPackageError) as raised:
        load_registry().make("importer", "tdms", {})
    assert raised.value.hint == "pip install 'rigrunner[tdms]'"


def test_other_files_are_refused(tmp_path):
    path = tmp_path / "a.tdms"
    path.write_bytes(b"TDSh0000")
    with pytest.raises(DataError, match=r"is not a TDMS file .this is the index of one"):
        read(path)
    with pytest.raises(DataError, match="No such file"):
        read(tmp_path / "none.tdms")


def test_default_start_time_is_none(tmp_path):
    zero = {"wf_start_time": np.datetime64("1904-01-01T00:00:00", "us")}
    column = read(write(tmp_path / "a.tdms", torque(**zero)))
    assert (column.started, column.interval_s, column.unit) == (None, None, "")


def append(path, data, microseconds, **properties):
    start = {"wf_start_time": START + np.timedelta64(microseconds, "us"), **properties}
    with TdmsWriter(path, mode="a") as writer:
        writer.write_segment([torque(data=data, wf_increment=1e-4, **start)])


def test_appended_segments_have_their_start_times(tmp_path):
    first = torque(wf_increment=1e-4, wf_start_time=START)
    path = write(tmp_path / "a.tdms", torque("other"), first)
    append(path, np.arange(5.0), 400)
    append(path, np.arange(2.0), 0, wf_start_offset=9e-4)
    column = TdmsImporter(NoSettings()).read(path, {"torque": "Torque"}, "r1")["torque"]
    assert len(column.values) == 3 + 5 + 2
    utc = datetime(2026, 3, 2, 9, 15, tzinfo=UTC)
    first, second = column.goes
    assert (column.started, column.offset_s) == (utc + timedelta(seconds=0.25), 0.0)
    assert first == (3, utc + timedelta(seconds=0.2504))
    assert second == (8, utc + timedelta(seconds=0.2509))


def test_contiguous_appended_segments_form_one_recording(tmp_path):
    path = write(tmp_path / "a.tdms", torque(wf_increment=1e-4, wf_start_time=START))
    for i in range(1, 20):
        append(path, TORQUE, 300 * i)
    columns = {"torque": read(path)}
    assert len(columns["torque"].goes) == 19
    assert start_of(columns, 1e4, "f") == datetime(2026, 3, 2, 9, 15, 0, 250_000, tzinfo=UTC)
    append(path, TORQUE, 6500)
    with pytest.raises(DataError, match=r"'torque' has a gap: sample 61 was taken 0\.0005 s later"):
        start_of({"torque": read(path)}, 1e4, "f")


def test_start_stated_once_is_one_segment(tmp_path):
    path = write(tmp_path / "a.tdms", torque(), parts=4)
    assert read(path).goes == ()


@pytest.mark.parametrize(
    ("unit", "interval_s"),
    [("", 2.0), ("s", 2.0), ("ms", 2e-3), ("Hz", None), ("mm", None), ("steps", None)],
)
def test_interval_is_converted_from_its_unit_of_time(tmp_path, unit, interval_s):
    properties = {"wf_increment": 2.0, "wf_xunit_string": unit}
    assert read(write(tmp_path / "a.tdms", torque(**properties))).interval_s == interval_s


def test_unknown_scale_is_refused(tmp_path):
    scale = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Cubic spline"}
    with pytest.raises(DataError, match="a scale that is not known: Cubic spline"):
        read(write(tmp_path / "a.tdms", torque(**scale)))
    scaled = write(tmp_path / "b.tdms", torque(**scale, NI_Scaling_Status="scaled"))
    assert read(scaled).values.tolist() == TORQUE.tolist()


@pytest.mark.parametrize("of", ["group", "file"])
def test_scale_of_the_group_or_the_file_applies(tmp_path, of):
    linear = {
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": 2.0,
        "NI_Scale[0]_Linear_Y_Intercept": 0.0,
        "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
    }

    def written(properties, **channel_properties):
        path = tmp_path / "a.tdms"
        with TdmsWriter(path) as writer:
            root = RootObject(properties if of == "file" else {})
            group = GroupObject("r1", properties if of == "group" else {})
            writer.write_segment([root, group, torque(**channel_properties, unit_string="Nm")])
        return read(path).values.tolist()

    unknown = linear | {"NI_Scale[0]_Scale_Type": "Cubic spline"}
    assert written(linear) == (2 * TORQUE).tolist()
    with pytest.raises(DataError, match="a scale that is not known: Cubic spline"):
        written(unknown)
    assert written(unknown, **linear) == (2 * TORQUE).tolist()  # that of the channel applies
