"""How a run ended, as the screen shows it."""

from __future__ import annotations

from pathlib import Path

import pytest

from rigrunner.api.errors import AbortedError
from rigrunner.api.events import Outcome
from rigrunner.run.finish import FinishedRun
from rigrunner_panel.view.of_result import finished_view


@pytest.mark.parametrize("unsafe", ["", "tester: load reads back 50 N, safe is 0 N"])
def test_a_rig_that_is_not_safe_is_shown_beside_what_ended_the_run(unsafe):
    beside = f"; the rig is not safe: {unsafe}" if unsafe else ""
    ended = FinishedRun(
        folder=Path("runs/one"),
        outcome=Outcome.ERROR if unsafe else Outcome.ABORTED,
        reason=f"stopped at the panel{beside}",
        error=AbortedError("stopped at the panel", by="me"),
        unsafe=unsafe,
    )
    assert finished_view(ended).error == f"stopped at the panel{beside}"
