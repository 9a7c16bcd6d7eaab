"""What is sound of a damaged file, told by its manifest or else by the recordings' own digests."""

from __future__ import annotations

from pathlib import Path

import h5py
import pytest

from rigrunner.runfile.salvage import read_damaged, write_salvaged
from unit.runfile.helpers_runfile import TWO, header_of, write_run

PLACES = tuple(f"recordings/_{original.name}" for original in TWO)


@pytest.fixture
def path(tmp_path):
    sealed = write_run(tmp_path / "run", TWO).seal()
    sealed.chmod(0o644)
    return sealed


def test_of_a_sound_file_nothing_is_lost(path):
    damaged = read_damaged(path)
    assert tuple(damaged.sound) == PLACES
    assert damaged.lost == ()


def test_a_run_without_an_embedded_one_has_none(path):
    assert read_damaged(path).partners == ()


def test_without_its_manifest_recordings_are_found_by_their_own_digests(path):
    with h5py.File(path, "r+") as file:
        manifest = file["entry/manifest"]
        manifest[0] = ord("[")
        second = file[f"entry/{PLACES[1]}/tester_torque"]
        second[5] = second[5] + 1.0
    damaged = read_damaged(path)
    assert tuple(damaged.sound) == PLACES[:1]
    assert [difference.path for difference in damaged.lost] == ["manifest", PLACES[1]]


def test_ctrl_c_while_a_damaged_file_is_read_is_not_taken_for_damage(path, monkeypatch):
    def interrupted(*_arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("rigrunner.runfile.salvage.mismatch", interrupted)
    with pytest.raises(KeyboardInterrupt):
        read_damaged(path)


@pytest.mark.parametrize("has_manifest", [True, False])
def test_an_embedded_run_that_is_damaged_is_not_taken_for_sound(tmp_path, has_manifest):
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


def test_of_a_file_from_before_there_was_a_manifest_recordings_are_found_by_their_own_digests():
    path = Path(__file__).parents[2] / "data" / "format-1" / "run.h5"
    with h5py.File(path) as file:
        recorded = set(file["entry/recordings"])
    damaged = read_damaged(path)
    assert set(damaged.recordings) == recorded != set()
    assert "manifest" not in {difference.path for difference in damaged.lost}


def test_who_approved_the_procedure_is_kept(tmp_path):
    approval = {"state": "approved", "by": "Ada"}
    header = header_of("run", approval=approval)
    sealed = write_run(tmp_path / "run", TWO[:1], header=header).seal()
    assert read_damaged(sealed).header.approval == approval


def test_ctrl_c_while_a_header_is_read_is_not_taken_for_damage(path, monkeypatch):
    def interrupted(_group, name):
        if name == "run_id":
            raise KeyboardInterrupt
        return ""

    monkeypatch.setattr("rigrunner.runfile.salvage.read_text", interrupted)
    with pytest.raises(KeyboardInterrupt):
        read_damaged(path)
