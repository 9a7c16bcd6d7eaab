"""Intact parts of a damaged file, found by its manifest or else by the recordings' digests."""

from __future__ import annotations

from pathlib import Path

import h5py
import pytest

from rigrunner.runfile import read
from rigrunner.runfile.salvage import _Reader, read_damaged, write_salvaged
from unit.runfile.helpers_runfile import TWO, header_of, write_run

PLACES = tuple(f"recordings/_{original.name}" for original in TWO)


@pytest.fixture
def path(tmp_path):
    sealed = write_run(tmp_path / "run", TWO).seal()
    sealed.chmod(0o644)
    return sealed


def test_intact_file_loses_nothing(path):
    damaged = read_damaged(path)
    assert tuple(damaged.sound) == PLACES
    assert damaged.lost == ()
    assert list(damaged.events) == list(read(path.parent).events)


def test_run_keeps_its_name_in_another_folder(tmp_path):
    sealed = write_run(tmp_path / "copy", TWO[:1], header=header_of("R-7")).seal()
    assert read_damaged(sealed).header.run_id == "R-7"


class Unlisted:
    """A group whose list of members cannot be read."""

    def __init__(self, error):
        self.error = error

    def __contains__(self, _name):
        raise self.error


def test_recordings_that_cannot_be_listed_are_those_of_the_manifest():
    reader = _Reader(Unlisted(OSError("bad checksum")))
    assert reader._members("recordings", ["recordings/_b", "recordings/_a", "events"]) == [
        "_a", "_b",
    ]  # fmt: skip
    assert "cannot be listed, it is damaged: bad checksum" in reader.lost["recordings"].what
    with pytest.raises(KeyboardInterrupt):
        _Reader(Unlisted(KeyboardInterrupt()))._members("recordings", [])


def test_unreadable_part_is_replaced_and_noted_as_lost():
    def fail():
        raise OSError("bad checksum")

    reader = _Reader({})
    assert reader._part("inputs", fail, {"operator": ""}) == {"operator": ""}
    assert list(reader.lost) == ["inputs"]


def test_run_without_partners_has_none(path):
    assert read_damaged(path).partners == ()


def test_recordings_without_a_manifest_are_checked_by_their_digests(path):
    with h5py.File(path, "r+") as file:
        manifest = file["entry/manifest"]
        manifest[0] = ord("[")
        second = file[f"entry/{PLACES[1]}/tester_torque"]
        second[5] = second[5] + 1.0
    damaged = read_damaged(path)
    assert tuple(damaged.sound) == PLACES[:1]
    assert [difference.path for difference in damaged.lost] == ["manifest", PLACES[1]]


def test_ctrl_c_while_reading_a_damaged_file_is_raised(path, monkeypatch):
    def interrupted(*_arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("rigrunner.runfile.salvage.mismatch", interrupted)
    with pytest.raises(KeyboardInterrupt):
        read_damaged(path)


@pytest.mark.parametrize("has_manifest", [True, False])
def test_damaged_embedded_run_is_lost(tmp_path, has_manifest):
    for name in ("before", "after"):
        write_run(tmp_path / name, TWO[:1]).seal()
    sealed = write_run(tmp_path / "run", TWO).seal(
        partners={"no_load": tmp_path / "before", "no_load_after": tmp_path / "after"}
    )
    assert read_damaged(sealed).partners == ("no_load", "no_load_after")
    sealed.chmod(0o644)
    with h5py.File(sealed, "r+") as file:
        column = file[f"entry/no_load/{PLACES[0]}/tester_torque"]
        column[5] = column[5] + 1.0
        if not has_manifest:
            file["entry/manifest"][0] = ord("[")
    damaged = read_damaged(sealed)
    assert damaged.partners == ("no_load_after",)
    assert tuple(damaged.sound) == PLACES
    assert any(difference.path.partition("/")[0] == "no_load" for difference in damaged.lost)
    target = tmp_path / "saved.h5"
    write_salvaged(damaged, damaged.header, damaged.events, target)
    with h5py.File(target) as file:
        assert "no_load_after" in file["entry"]
        assert "no_load" not in file["entry"]


def test_recordings_of_format_1_are_checked_by_their_digests():
    path = Path(__file__).parents[2] / "data" / "format-1" / "run.h5"
    with h5py.File(path) as file:
        recorded = set(file["entry/recordings"])
    damaged = read_damaged(path)
    assert set(damaged.recordings) == recorded != set()
    assert "manifest" not in {difference.path for difference in damaged.lost}


def test_approval_of_the_procedure_is_kept(tmp_path):
    approval = {"state": "approved", "by": "Ada"}
    header = header_of("run", approval=approval)
    sealed = write_run(tmp_path / "run", TWO[:1], header=header).seal()
    assert read_damaged(sealed).header.approval == approval


def test_ctrl_c_while_reading_a_header_is_raised(path, monkeypatch):
    def interrupted(_group, name):
        if name == "run_id":
            raise KeyboardInterrupt
        return ""

    monkeypatch.setattr("rigrunner.runfile.salvage.read_text", interrupted)
    with pytest.raises(KeyboardInterrupt):
        read_damaged(path)
