from __future__ import annotations

import re
from datetime import datetime, timedelta, timezone
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.errors import DataError
from rigrunner.runfile import create_run_folder, folder, read
from rigrunner.runfile.folder import RunFolder, safe_name
from unit.runfile.helpers_runfile import START


def test_folder_is_named_by_time_procedure_and_specimen(tmp_path):
    folder = create_run_folder(tmp_path / "runs", START, "SSPB-STT-1000", "DEMO-0001")
    assert folder == tmp_path / "runs" / "20260301T120000Z_SSPB-STT-1000_DEMO-0001"
    assert folder.is_dir()


def test_time_is_utc_and_specimen_may_be_missing(tmp_path):
    started = datetime(2026, 3, 1, 21, 0, tzinfo=timezone(timedelta(hours=9)))
    assert create_run_folder(tmp_path, started, "P").name == "20260301T120000Z_P"


def test_taken_names_get_a_number(tmp_path):
    names = [create_run_folder(tmp_path, START, "P", "S").name for _ in range(3)]
    assert names == [f"20260301T120000Z_P_S{end}" for end in ("", "-2", "-3")]


def test_the_name_of_a_run_is_on_the_disk_before_anything_is_recorded(tmp_path, monkeypatch):
    synced = []
    monkeypatch.setattr(folder, "sync_folder", synced.append)
    create_run_folder(tmp_path / "runs", START, "P", "S")
    assert synced == [tmp_path / "runs"]


@pytest.mark.parametrize(
    ("text", "safe"),
    [
        ("../../etc/passwd", "etc-passwd"),
        ("a b\tc\\d:e*f", "a-b-c-d-e-f"),
        ("Prüfling Ø12", "Prufling-12"),
        ("轴承", ""),
        ("x" * 300, "x" * 48),
        ("trailing. ", "trailing"),
        ("a.b-1", "a.b-1"),
    ],
)
def test_names_are_made_safe(text, safe):
    assert safe_name(text) == safe


@given(st.text())
def test_any_name_is_safe_on_every_file_system(text):
    assert re.fullmatch(r"|[A-Za-z0-9]([A-Za-z0-9.-]{0,46}[A-Za-z0-9])?", safe_name(text))


def test_folder_that_cannot_be_made_is_told(tmp_path):
    (tmp_path / "runs").write_text("a file is in the way")
    with pytest.raises(DataError, match=r"cannot write .*runs.*the disk full"):
        create_run_folder(tmp_path / "runs", START, "P")


@pytest.mark.parametrize(
    ("kept", "hint"),
    [
        ("recordings/000001.h5", "samples were recorded: keep the folder"),
        ("journal/000001.samples", "samples were recorded: keep the folder"),
        ("run.log", "nothing was recorded: remove the folder"),
    ],
)
def test_a_run_that_lost_its_header_is_thrown_away_only_where_it_holds_no_samples(
    tmp_path, kept, hint
):
    for name in ("journal", "recordings"):
        (tmp_path / name).mkdir()
    RunFolder(tmp_path).events.write_bytes(b"")
    (tmp_path / kept).write_bytes(b"samples")
    with pytest.raises(DataError, match="ends before the run's header") as caught:
        read(tmp_path)
    assert hint in caught.value.hint


def test_ctrl_c_while_the_folder_of_a_run_is_made_is_not_taken_for_one_that_is_there(
    tmp_path, monkeypatch
):
    (tmp_path / "runs").mkdir()
    presses = iter([KeyboardInterrupt])

    def press(_path):
        for press in presses:
            raise press

    monkeypatch.setattr(Path, "mkdir", press)
    with pytest.raises(KeyboardInterrupt):
        folder._first_free(tmp_path / "runs", "run")
