"""Requirements of analyses for partner runs."""

from __future__ import annotations

import pytest

from rigrunner.api.analysis import NeededRun


def test_run_after_this_one_cannot_be_a_certain_run():
    assert NeededRun(name="dark_after", key=("dark",), after=True).run == "latest"
    with pytest.raises(
        ValueError, match=r"'dark_after' is made after this run: expected run='latest'"
    ):
        NeededRun(name="dark_after", key=("dark",), after=True, run="DARK-1")
