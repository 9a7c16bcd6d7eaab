"""The demonstration: both shipped procedures on the simulated station, one after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.engine import UnattendedAnswers
from rigrunner.run.inputs import answer_inputs
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.partners import partners_for
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute
from rigrunner_bearings.labs import PROCEDURES

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from rigrunner.api import Clock, EventSink, StopToken
    from rigrunner.registry import Registry
    from rigrunner.run.finish import FinishedRun

STATION = "simulated"


def run_demo(
    runs: Path,
    registry: Registry,
    clock: Clock,
    stop: StopToken,
    listeners: Sequence[EventSink] = (),
) -> Iterator[FinishedRun]:
    """Do the no-load run, then the loaded run that is compensated with it; stop at a failure."""
    answers = UnattendedAnswers()
    for name in PROCEDURES:
        planned = plan_run(find_procedure(name), find_station(STATION), registry, clock)
        finished = execute(
            planned,
            runs=runs,
            inputs=answer_inputs(planned.procedure, {}, answers),
            partners=partners_for(planned, runs),
            answers=answers,
            stop=stop,
            listeners=listeners,
        )
        yield finished
        if finished.error is not None:
            return
