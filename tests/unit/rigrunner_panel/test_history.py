"""The rows of the stored runs, which are cached."""

from __future__ import annotations

import shutil
import weakref

from rigrunner_panel.history import History


def test_row_of_a_removed_run_is_not_kept(tmp_path):
    folder = tmp_path / "20260101T000000Z_one"
    folder.mkdir()
    (folder / "run.h5").touch()
    history = History(tmp_path)
    row = weakref.ref(history.item(folder.name))
    assert row() is history.item(folder.name)
    shutil.rmtree(folder)
    assert list(history.items()) == []
    assert row() is None
