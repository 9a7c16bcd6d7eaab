"""The parts of a run that was interrupted and resumed."""

from __future__ import annotations

from rigrunner.api.events import RESUME_RUN, Intervention, StepStarted
from rigrunner.runfile.parts import parts_of


def test_each_resumption_begins_a_part():
    stamp = {"seq": 0, "monotonic_s": 0.0, "utc": ""}
    step = {"step": "main[0]", "index": 0, "action": "record", "text": ""}
    resumed = Intervention(**stamp, action=RESUME_RUN, by="Ada")
    paused = Intervention(**stamp, action="pause", by="Ada")
    first, second, third = (StepStarted(**stamp, **step, recording=name) for name in "abc")
    assert parts_of([first, paused, resumed, second, resumed, third]) == {"a": 1, "b": 2, "c": 3}
