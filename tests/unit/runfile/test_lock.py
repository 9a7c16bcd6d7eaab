"""Who writes to a run's folder."""

from __future__ import annotations

from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.lock import is_going_on, run_lock


def test_a_run_goes_on_only_while_somebody_has_its_lock(tmp_path):
    assert is_going_on(tmp_path) is False
    assert not RunFolder(tmp_path).lock.exists()
    with run_lock(tmp_path):
        assert is_going_on(tmp_path) is True
    assert is_going_on(tmp_path) is False
