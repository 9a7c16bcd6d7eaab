from __future__ import annotations

import json
import re
import stat

import h5py
import numpy as np
import pytest

from rigrunner.api.data import Measurement
from rigrunner.api.errors import DataError
from rigrunner.runfile import read, read_info, read_truth, reading, seal
from rigrunner.runfile.compressed import LongText
from rigrunner.runfile.measurements import write_measurements
from unit.runfile.helpers_runfile import DOCUMENT, PLOT, TWO, header_of, recording, write_run


@pytest.fixture
def folder(tmp_path):
    write_run(tmp_path / "run", TWO).seal(DOCUMENT, PLOT)
    return tmp_path / "run"


@pytest.fixture
def file(folder):
    with h5py.File(folder / "run.h5", "r") as file:
        yield file


def change(folder, edit):
    path = folder / "run.h5"
    path.chmod(0o644)
    with h5py.File(path, "r+") as file:
        edit(file)


def test_default_plot_is_found_from_the_root(file):
    group = file
    while "default" in group.attrs:
        group = group[group.attrs["default"]]
    assert group.name == "/entry/analysis/torque"
    assert group.attrs["NX_class"] == "NXdata"
    assert group.attrs["signal"] == "compensated"
    assert list(group.attrs["axes"]) == ["frequency"]
    assert list(group["frequency"][()]) == [0.0, 1.0]
    assert list(group["raw"][()]) == [1.0, 2.0]
    assert list(group["compensated"][()]) == [2.0, 3.0]
    assert list(group["compensated_errors"][()]) == [3.0, 4.0]
    assert group["compensated"].attrs["units"] == "N·m"
    assert group["compensated"].attrs["long_name"] == "compensated / N·m"
    assert list(group.attrs["auxiliary_signals"]) == ["raw"]


def test_without_analysis_the_first_recording_is_the_default_plot(tmp_path):
    path = write_run(tmp_path / "run", TWO).seal()
    with h5py.File(path, "r") as file:
        group = file["entry/recordings/_001_10Hz"]
        assert file["entry"].attrs["default"] == "recordings"
        assert file["entry/recordings"].attrs["default"] == "_001_10Hz"
        assert group.attrs["signal"] == "tester_torque"
        assert list(group.attrs["axes"]) == ["time"]
        assert group["time"][1] == 1e-4
        assert group["time"].attrs["units"] == "s"
        assert group["tester_angle"].attrs["units"] == "rad"
        assert group["tester_torque"].attrs["long_name"] == "tester.torque / N·m"


def test_every_name_is_one_that_nexus_allows(file):
    """By the rule for names in the NeXus manual: a letter or '_', then digits too."""
    names = []
    file.visit(lambda path: names.append(path.rpartition("/")[2]))
    assert "_001_10Hz" in names
    assert [name for name in names if not re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name)] == []


def test_every_group_has_a_nexus_class(file):
    classes = {file.attrs["NX_class"]}
    file.visititems(
        lambda _, item: (
            classes.add(item.attrs["NX_class"]) if isinstance(item, h5py.Group) else None
        )
    )
    assert classes == {"NXroot", "NXentry", "NXcollection", "NXdata", "NXprocess"}


def test_storage_is_what_every_reader_knows(file):
    column = file["entry/recordings/_002_20Hz/tester_torque"]
    assert column.dtype == "<f8"
    assert (column.compression, column.compression_opts) == ("gzip", 1)
    assert column.shuffle
    assert column.fletcher32
    kinds = set()
    file.visititems(
        lambda _, item: kinds.add(item.dtype.str[:2]) if isinstance(item, h5py.Dataset) else None
    )
    assert kinds == {"<f", "<i", "|S", "|u"}


def test_events_are_parallel_columns(file):
    events = file["entry/events"]
    assert {len(column) for column in events.values()} == {2 + 1 + 2 * len(TWO)}
    assert events["kind"][0] == b"RunStarted"
    assert events["seq"].dtype == np.int64
    assert json.loads(events["json"][-1])["outcome"] == "completed"


def test_texts_are_there_byte_by_byte(file):
    expected = header_of().procedure_text.encode()
    assert bytes(file["entry/texts/procedure_text"][()]) == expected
    assert json.loads(bytes(file["entry/analysis/result"][()])) == DOCUMENT


def test_file_has_the_form_of_hdf5_1_10_which_has_checksums_on_its_structure(folder):
    """The superblock's version stands at byte 8 (HDF5 file format specification, II.A)."""
    assert (folder / "run.h5").read_bytes()[8] == 3


def test_sealed_file_is_read_only_and_never_written_again(folder):
    assert stat.S_IMODE((folder / "run.h5").stat().st_mode) == 0o444
    with pytest.raises(DataError, match="is sealed, and is never written again"):
        seal(folder)


def test_reading_leaves_the_file_as_it_is(folder):
    before = (folder / "run.h5").read_bytes()
    read(folder), read_info(folder), read_truth(folder)
    assert (folder / "run.h5").read_bytes() == before


def test_long_and_odd_texts_survive(tmp_path):
    odd = {"note": "ä" * 70_000, "nul": "a\0b", "": "nothing", "a/b": "\ud800".encode(
        errors="surrogatepass").decode(errors="replace")}  # fmt: skip
    write_run(tmp_path / "run", [], header=header_of(inputs=odd, plan_text=LongText())).seal()
    assert read(tmp_path / "run").header.inputs == odd


def test_channel_names_that_collide_in_hdf5_stay_apart(tmp_path):
    original = recording(samples=10)
    channels = {
        name: np.full(10, float(number))
        for number, name in enumerate(["time", "a.b", "a_b", "a/b", "setpoints", ".", "µ"])
    }
    odd = type(original)("a/b", 10.0, "", {}, channels, {})
    write_run(tmp_path / "run", [odd]).seal()
    (stored,) = read(tmp_path / "run").recordings
    assert {name: values[0] for name, values in stored.channels.items()} == {
        name: values[0] for name, values in channels.items()
    }


@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.9, 0.999])
def test_truncated_file_is_told(folder, share):
    path = folder / "run.h5"
    content = path.read_bytes()
    path.chmod(0o644)
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(DataError, match=r"run\.h5 cannot be read: .*truncated.*from a copy"):
        read(folder)


def test_what_is_not_a_run_is_told(tmp_path):
    with pytest.raises(DataError, match="there is no run"):
        read(tmp_path / "nowhere")
    with pytest.raises(DataError, match=r"is not a run.*run folder has"):
        read(tmp_path)
    (tmp_path / "text.h5").write_text("hello")
    with pytest.raises(DataError, match="not an HDF5 file"):
        read(tmp_path / "text.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(DataError, match="an HDF5 file, but not a run of Rigrunner"):
        read(tmp_path / "other.h5")


def test_newer_version_is_told(folder, tmp_path):
    change(folder, lambda file: file.attrs.modify("rigrunner_format", 5))
    with pytest.raises(DataError, match=r"newer version of Rigrunner \(format 5, .* up to 4\)"):
        read(folder)
    write_run(tmp_path / "loose", TWO)
    journal = tmp_path / "loose" / "journal" / "events.journal"
    assert b'"format": 4' in journal.read_bytes()


def test_missing_part_is_told(folder):
    change(folder, lambda file: file.__delitem__("entry/zeros"))
    with pytest.raises(DataError, match="not a run of Rigrunner, or damaged"):
        read(folder)


def sample(file):
    file["entry/recordings/_001_10Hz/tester_torque"][17] += 1e-12


def setpoint(file):
    file["entry/recordings/_001_10Hz/setpoints/tester_load"][()] = 1001.0


def rate(file):
    file["entry/recordings/_001_10Hz"].attrs["rate_hz"] = 9999.0


def unit(file):
    file["entry/recordings/_001_10Hz/tester_torque"].attrs["units"] = "mN·m"


@pytest.mark.parametrize("edit", [sample, setpoint, rate, unit])
def test_changed_recording_is_told(folder, edit):
    change(folder, edit)
    with pytest.raises(DataError, match="recording '001_10Hz' is not what was recorded"):
        read(folder)


def removed(file):
    del file["entry/recordings/_001_10Hz"]


def swapped(file):
    group = file["entry/recordings"]
    group["_001_10Hz"].attrs["number"], group["_002_20Hz"].attrs["number"] = 2, 1


@pytest.mark.parametrize("edit", [removed, swapped])
def test_changed_set_of_recordings_is_told(folder, edit):
    change(folder, edit)
    for reader in (read, read_info):
        with pytest.raises(DataError, match="not those that were sealed"):
            reader(folder)


def test_flipped_byte_in_samples_is_told(folder):
    path = folder / "run.h5"
    with h5py.File(path, "r") as file:
        chunk = file["entry/recordings/_001_10Hz/tester_torque"].id.get_chunk_info(0)
    content = bytearray(path.read_bytes())
    content[chunk.byte_offset + chunk.size // 2] ^= 1
    path.chmod(0o644)
    path.write_bytes(content)
    with pytest.raises(DataError, match="damaged"):
        read(folder)


def test_run_is_found_by_folder_and_by_file(folder):
    assert read(folder).digest == read(folder / "run.h5").digest


def test_rest_of_a_run_whose_removal_was_cut_short_does_no_harm(tmp_path, folder):
    write_run(tmp_path / "other", TWO[:1])
    (tmp_path / "other" / "journal").rename(folder / "journal")
    (tmp_path / "other" / "recordings").rename(folder / "recordings")
    assert read(folder).info.recording_names == ("001_10Hz", "002_20Hz")


def test_half_written_files_of_a_killed_sealing_are_overwritten(tmp_path):
    write_run(tmp_path / "run", TWO)
    (tmp_path / "run" / "run.h5.tmp").write_bytes(b"half")
    (tmp_path / "run" / "recordings" / "000003.h5.tmp").write_bytes(b"half")
    assert len(read(tmp_path / "run").recordings) == 2
    seal(tmp_path / "run")
    assert len(read(tmp_path / "run").recordings) == 2
    assert not (tmp_path / "run" / "run.h5.tmp").exists()


def test_sealing_keeps_the_order_of_named_texts(tmp_path):
    inputs = {"specimen": "A", "operator": "B", "batch": "C"}
    writer = write_run(tmp_path / "run", [], header=header_of(inputs=inputs))
    assert list(read(tmp_path / "run").header.inputs) == list(inputs)
    writer.seal()
    assert list(read(tmp_path / "run").header.inputs) == list(inputs)


def test_the_plot_of_an_embedded_run_is_its_first_recording(tmp_path):
    """Its analysis, which it would begin with, is not embedded."""
    write_run(tmp_path / "no_load", TWO).seal(DOCUMENT, PLOT)
    path = write_run(tmp_path / "run", TWO).seal(partners={"no_load": tmp_path / "no_load"})
    with h5py.File(path) as file:
        group = file["entry/no_load"]
        while "default" in group.attrs:
            group = group[group.attrs["default"]]
        assert group.name == "/entry/no_load/recordings/_001_10Hz"


def test_a_run_that_must_not_be_read_is_told_as_such(folder, monkeypatch):
    def deny(_path):
        raise PermissionError(13, "denied")

    monkeypatch.setattr(reading, "_sealed_file_of", deny)
    with pytest.raises(DataError, match=r"no permission to read .*run") as error:
        reading.sealed_file_of(folder)
    assert error.value.hint == "ask its owner for permission to read it"


def test_arrays_of_one_length_are_a_table_and_others_are_texts(tmp_path):
    def row(spectrum, wave):
        all_readings = {"box.spectrum": spectrum, "box.wave": wave}
        readings = {name: value for name, value in all_readings.items() if value is not None}
        units = {"box.spectrum": "V", "box.wave": "V"}
        return Measurement("cell", "2026-03-01T12:00:00.000Z", {}, {}, units, readings=readings)

    with h5py.File(tmp_path / "x.h5", "w") as file:
        rows = [row((1.0, 2.0), (1.0,)), row(None, (1.0, 2.5)), row((3.0, 4.0), None)]
        write_measurements(file, rows)
        tables = [value for value in file["measurements"].values() if "readings" in value]
        columns = {value.attrs["name"]: value for value in tables[0]["readings"].values()}
        spectrum, wave = columns["box.spectrum"], columns["box.wave"]
        np.testing.assert_array_equal(spectrum[()], [[1, 2], [np.nan, np.nan], [3, 4]])
        assert spectrum.dtype == np.float64
        assert list(wave.asstr()[()]) == ["1.0", "1.0 2.5", ""]
        assert spectrum.attrs["units"] == "V"
