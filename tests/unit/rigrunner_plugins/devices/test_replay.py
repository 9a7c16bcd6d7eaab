import csv
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from helpers_thorough import examples
from rigrunner.api.devices import DeviceContext
from rigrunner.api.errors import (
    DataError,
    DeviceNotFoundError,
    DeviceRejectedError,
    InvalidFileError,
)
from rigrunner.clock import SimulatedClock
from rigrunner_plugins.devices.replay.device import Replay
from rigrunner_plugins.devices.replay.settings import ReplaySettings
from rigrunner_plugins.devices.replay.texts import read_texts
from rigrunner_plugins.importers.csv_file import read_csv
from rigrunner_plugins.importers.settings import TableSettings

RATE = 1000.0
TORQUE = np.sin(np.arange(300) / 7) + 0.1
ANGLE = 0.04 * np.cos(np.arange(300) / 7)
MANIFEST = """\
rigrunner: replay/1
recordings:
  - {frequency: 0 Hz, load: 0 N, values: {torque: 12.5 mN·m}}
  - {frequency: 10 Hz, load: 0 N, file: plain.csv, values: {temperature: 23 °C}}
  - {frequency: 10 Hz, load: 1 kN, file: runs/all.h5, group: /loaded/10}
"""
CHANNELS = {
    "angle": {"column": "angle", "unit": "rad"},
    "torque": {"column": "torque", "unit": "N·m", "title": "Torque"},
    "temperature": {"unit": "°C"},
}


class Never:
    def is_set(self):
        return False


@pytest.fixture
def folder(tmp_path):
    """A station's folder with recordings in `data`."""
    data = tmp_path / "data"
    (data / "runs").mkdir(parents=True)
    (data / "manifest.yaml").write_text(MANIFEST)
    write_csv(data / "plain.csv", ["angle", "torque"], [ANGLE, TORQUE])
    with h5py.File(data / "runs" / "all.h5", "w") as file:
        file["loaded/10/angle"] = ANGLE
        file["loaded/10/torque"] = 2 * TORQUE
    return tmp_path


def write_csv(path, names, columns, delimiter=",", decimal="."):
    rows = [[repr(float(x)).replace(".", decimal) for x in row] for row in zip(*columns)]  # noqa: B905  (equal)
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, delimiter=delimiter).writerows([names, *rows])


def make(station, **changes):
    settings = {"folder": "data", "rate": "1 kHz", "channels": CHANNELS} | changes
    context = DeviceContext("tester", SimulatedClock(), station)
    return Replay(ReplaySettings.model_validate(settings), context)


def connect(station, **changes):
    device = make(station, **changes)
    device.connect(1.0)
    return device


def play(device, frequency, load, seconds=0.3, channels=("angle", "torque")):
    device.set("load", load)
    device.set("frequency", frequency)
    blocks = list(device.stream(channels, seconds, Never()))
    return {name: np.concatenate([block.channels[name] for block in blocks]) for name in channels}


def problems(folder, manifest, **changes):
    (folder / "data" / "manifest.yaml").write_text(manifest)
    with pytest.raises(InvalidFileError) as raised:
        connect(folder, **changes)
    return str(raised.value)


def test_csv_and_hdf5_are_played_at_their_set_points(folder):
    device = connect(folder)
    unloaded, loaded = play(device, 10.0, 0.0), play(device, 10.0, 1000.0)
    assert np.array_equal(unloaded["torque"], TORQUE)
    assert np.array_equal(loaded["torque"], 2 * TORQUE)
    assert np.array_equal(unloaded["angle"], ANGLE)


def test_other_names_units_delimiter_and_decimal_comma_play_the_same(folder):
    columns = [1e3 * TORQUE, np.rad2deg(ANGLE)]
    write_csv(folder / "data" / "plain.csv", ["Md [mNm]", "Winkel"], columns, ";", ",")
    channels = CHANNELS | {
        "angle": {"column": "Winkel", "unit": "°"},
        "torque": {"column": "Md [mNm]", "unit": "mNm"},
    }
    device = connect(folder, channels=channels, table={"delimiter": ";", "decimal": ","})
    played = play(device, 10.0, 0.0)
    assert played["torque"] == pytest.approx(TORQUE, rel=1e-14)
    assert played["angle"] == pytest.approx(ANGLE, rel=1e-14)


@pytest.mark.parametrize("of", ["csv", "hdf5"])
def test_unit_that_contradicts_the_file_is_refused(folder, of):
    """A value of 12.5 in a column in mN·m was once played as 12.5 N·m."""
    name = "torque [mNm]" if of == "csv" else "torque"
    if of == "csv":
        write_csv(folder / "data" / "plain.csv", ["angle", name], [ANGLE, TORQUE])
    else:
        with h5py.File(folder / "data" / "runs" / "all.h5", "a") as file:
            file["loaded/10/torque"].attrs["units"] = "mNm"
    at = {"csv": 0.0, "hdf5": 1000.0}[of]
    torque = {"column": name, "unit": "N·m"}
    device = connect(folder, channels=CHANNELS | {"torque": torque})
    with pytest.raises(DeviceRejectedError, match="states 'mNm' for 'torque', not 'N·m'"):
        play(device, 10.0, at)
    torque["unit"] = "mN·m"
    played = play(connect(folder, channels=CHANNELS | {"torque": torque}), 10.0, at)
    assert played["torque"] == pytest.approx((1 if of == "csv" else 2) * TORQUE / 1e3)


def test_columns_without_names_may_be_numbered(folder):
    text = "made by hand\nJan 1\n" + "\n".join(f"{k}\t{k / 4}\t{-k}" for k in range(300)) + "\n"
    (folder / "data" / "plain.csv").write_text(text)
    channels = CHANNELS | {
        "angle": {"column": 2, "unit": "rad"},
        "torque": {"column": 3, "unit": "N·m"},
    }
    table = {"delimiter": "tab", "header": False, "skip_lines": 2}
    played = play(connect(folder, channels=channels, table=table), 10.0, 0.0)
    assert np.array_equal(played["angle"], np.arange(300) / 4)
    assert np.array_equal(played["torque"], -np.arange(300.0))


def test_constants_of_the_manifest_replace_columns(folder):
    device = connect(folder)
    assert np.array_equal(
        play(device, 0.0, 0.0, channels=("torque",))["torque"], np.full(300, 0.0125)
    )
    device.set("frequency", 10.0)
    assert device.read(["temperature"]) == {"temperature": 296.15}
    assert device.read(["torque"]) == {"torque": TORQUE[0]}


def test_channels_are_in_si_units(folder):
    info = {channel.name: channel for channel in make(folder).channels}
    assert info["temperature"].unit == "K"
    assert info["torque"].long_name == "Torque"


def test_missing_set_point_lists_those_of_the_recordings(folder):
    device = connect(folder)
    device.set("frequency", 12.0)
    with pytest.raises(DeviceRejectedError) as raised:
        device.stream(["torque"], 0.1, Never())
    assert "no recording of 12 Hz at 0 N" in str(raised.value)
    assert "0 Hz at 0 N, 10 Hz at 0 N, 10 Hz at 1000 N" in str(raised.value)


def test_recording_that_is_too_short_is_refused(folder):
    device = connect(folder)
    device.set("frequency", 10.0)
    with pytest.raises(DeviceRejectedError, match=r"'plain.csv'.* has 300 samples, but 301"):
        device.stream(["torque"], 0.301, Never())


def test_channel_that_a_recording_lacks_is_named(folder):
    device = connect(folder)
    device.set("frequency", 10.0)
    device.set("load", 1000.0)
    with pytest.raises(DeviceRejectedError, match="10 Hz at 1000 N has no channel 'temperature'"):
        device.read(["temperature"])


def test_missing_folder_is_reported_as_device_not_found(folder):
    with pytest.raises(DeviceNotFoundError, match="nowhere"):
        connect(folder, folder="nowhere")


def test_missing_manifest_is_named(folder):
    with pytest.raises(InvalidFileError, match=r"data/other.yaml: there is no such file"):
        connect(folder, manifest="other.yaml")


def test_problems_of_a_manifest_are_reported_with_their_lines(folder):
    text = problems(
        folder,
        "rigrunner: replay/1\n"
        "recordings:\n"
        "  - {frequency: 10, load: 0 N, file: plain.csv}\n"
        "  - {frequency: 10 Hz, load: 5 Hz, file: plain.csv}\n"
        "  - frequency: 10 Hz\n"
        "    fil: plain.csv\n"
        "extra: 1\n",
    )
    assert "manifest.yaml:3:17: recordings[0].frequency: '10' has no unit" in text
    assert "manifest.yaml:4:30: recordings[1].load: '5 Hz' is a frequency" in text
    assert "manifest.yaml:5:5: recordings[2].load: is missing" in text
    assert "manifest.yaml:6:10: recordings[2].fil: is unknown; known are frequency, load" in text
    assert "manifest.yaml:7:8: extra: is unknown; known are rigrunner, recordings" in text


def test_set_points_files_and_values_are_checked_on_connect(folder):
    text = problems(
        folder,
        "rigrunner: replay/1\n"
        "recordings:\n"
        "  - {frequency: 1 Hz, load: 0 N, file: lost.csv}\n"
        "  - {frequency: 10 Hz, load: 1 kN, file: plain.csv, values: {mass: 1 kg}}\n"
        "  - {frequency: 10 Hz, load: 1000 N, file: plain.csv, values: {angle: 1 N·m}}\n"
        "  - {frequency: 11 Hz, load: 1000 N}\n",
    )
    assert ":3:40: recordings[0].file: 'lost.csv' is not there" in text
    assert "recordings[1].values.mass: there is no channel 'mass'; there are: angle" in text
    assert "recordings[2].values.angle: '1 N·m' is a torque, but an angle" in text
    assert "recordings[2]: 10 Hz at 1000 N is given twice" in text
    assert "recordings[3]: has neither a file nor values" in text


@pytest.mark.parametrize("way", ["../secret.csv", "/etc/hostname", "link.csv", "runs/../../s.csv"])
def test_path_out_of_the_folder_is_refused(folder, way):
    (folder / "secret.csv").write_text("angle,torque\n1,2\n")
    (folder / "s.csv").write_text("angle,torque\n1,2\n")
    (folder / "data" / "link.csv").symlink_to(folder / "secret.csv")
    entry = f"  - {{frequency: 1 Hz, load: 0 N, file: {way}}}\n"
    assert "leads out of the folder" in problems(
        folder, "rigrunner: replay/1\nrecordings:\n" + entry
    )


def test_manifest_outside_the_folder_is_refused(folder):
    (folder / "manifest.yaml").write_text(MANIFEST)
    with pytest.raises(InvalidFileError, match="leads out of the folder"):
        connect(folder, manifest="../manifest.yaml")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "Input should be a valid dictionary"),
        ("rigrunner: replay/1\nrigrunner: replay/1\n", ":2:1: the key 'rigrunner' is given twice"),
        ("a: &x [1]\nb: *x\n", ":2:4: aliases are not allowed"),
        ("a: [1\n", "not YAML"),
        ("? [1]\n: 2\n", "a key must be a text"),
        ("a: " + "[" * 50, "nested too deeply"),
        ("a: 1\n---\nb: 1\n", "not YAML"),
        ("a: " + "x" * 1_000_001, "is larger than"),
    ],
)
def test_invalid_yaml_is_refused(folder, text, message):
    assert message in problems(folder, text)


def test_manifest_that_is_not_utf_8_is_refused(folder):
    (folder / "data" / "manifest.yaml").write_bytes(b"rigrunner: \xff\n")
    with pytest.raises(InvalidFileError, match="is not UTF-8"):
        connect(folder)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("angle,twist\n1,2\n", "csv:1: the column 'torque' of 'torque' is not there"),
        ("angle,torque,torque\n1,2,3\n", "csv:1: the column 'torque' of 'torque' is given"),
        ("angle,torque\n1,2\n\n1\n", "csv:4: has 1 columns, 2 are needed"),
        ("angle,torque\n1,2\n1,x\n", "csv:3: 'x' is not a number"),
        ("angle,torque\n1,1_0\n", "csv:2: '1_0' is not a number"),
        ("angle,torque\n1,nan\n", "csv:2: 'nan' is not a number"),
        ('angle,torque\n1,"1,5"\n', "'1,5' is not a number with '.' as decimal mark"),
        ("angle;torque\n1;2\n", "columns: angle;torque"),
    ],
)
def test_invalid_csv_is_reported_with_its_line(folder, content, message):
    (folder / "data" / "plain.csv").write_text(content)
    device = connect(folder)
    device.set("frequency", 10.0)
    with pytest.raises(DataError) as raised:
        device.read(["torque"])
    assert message in str(raised.value)


def test_thousands_separator_is_refused(folder):
    (folder / "data" / "plain.csv").write_text("angle;torque\n1;1.234,5\n")
    device = connect(folder, table={"delimiter": ";", "decimal": ","})
    device.set("frequency", 10.0)
    with pytest.raises(DataError, match=r"'1\.234,5' is not a number with ',' as decimal mark"):
        device.read(["torque"])


def test_hdf5_must_contain_lists_of_finite_numbers(folder):
    path = folder / "data" / "runs" / "all.h5"
    with h5py.File(folder / "outside.h5", "w") as file:
        file["torque"] = TORQUE
    bad = {
        "is not there": lambda _: None,
        "is not a list of numbers": lambda group: group.create_group("torque"),
        "is not finite at sample 4": lambda group: group.create_dataset(
            "torque", data=[0, 1, 2, np.nan]
        ),
        "is kept in another file": lambda group: group.__setitem__(
            "torque", h5py.ExternalLink(str(folder / "outside.h5"), "torque")
        ),
    }
    for message, spoil in bad.items():
        with h5py.File(path, "w") as file:
            file["loaded/10/angle"] = ANGLE
            spoil(file["loaded/10"])
        with pytest.raises(DataError, match=f"'/loaded/10/torque' (of 'torque' )?{message}"):
            play(connect(folder), 10.0, 1000.0)
    path.write_bytes(b"no HDF5")
    with pytest.raises(DataError, match="is not a readable HDF5 file"):
        play(connect(folder), 10.0, 1000.0)


@pytest.mark.parametrize(
    "changes",
    [
        {"table": {"delimiter": ",", "decimal": ","}},
        {"rate": "0 Hz"},
        {"rate": 1000},
        {"channels": {}},
        {"channels": {"Torque!": {"column": "t", "unit": "N·m"}}},
        {"channels": {"torque": {"column": "t", "unit": "Nmm"}}},
        {"channels": {"torque": {"column": 0, "unit": "N·m"}}},
    ],
)
def test_invalid_settings_are_refused(folder, changes):
    with pytest.raises(ValidationError):
        make(folder, **changes)


numbers = st.floats(allow_nan=False, allow_infinity=False)


@settings(deadline=None, max_examples=examples(40))
@given(
    rows=st.lists(st.tuples(numbers, numbers), min_size=1, max_size=5),
    marks=st.sampled_from([(",", "."), (";", ","), ("|", ".")]),
)
def test_written_numbers_are_read_exactly(tmp_path_factory, rows, marks):
    path = tmp_path_factory.mktemp("csv") / "x.csv"
    delimiter, decimal = marks
    write_csv(path, ["a", "b"], list(zip(*rows, strict=True)), delimiter, decimal)
    columns = read_csv(
        path, {"first": "a", "second": 2}, TableSettings(delimiter=delimiter, decimal=decimal)
    )
    assert columns["first"].values.tolist() == [row[0] for row in rows]
    assert columns["second"].values.tolist() == [row[1] for row in rows]


@settings(deadline=None, max_examples=examples(150))
@given(text=st.text(st.sampled_from("ab:-[]{},&*?!|>'\"#%@\n\t 0é\\"), max_size=40))
def test_any_text_is_read_or_refused(tmp_path_factory, text):
    path = Path(tmp_path_factory.getbasetemp()) / "fuzz.yaml"
    path.write_text(text, encoding="utf-8")
    try:
        read_texts(path)
    except InvalidFileError:
        return
