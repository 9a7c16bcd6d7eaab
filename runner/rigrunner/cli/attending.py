"""Execute a planned run with a person at the terminal, or unattended."""

from __future__ import annotations

from contextlib import nullcontext
from typing import TYPE_CHECKING

from rigrunner.cli.answers import TerminalAnswers
from rigrunner.cli.output import message
from rigrunner.cli.pausing import TerminalPauses
from rigrunner.cli.progress import shown_progress
from rigrunner.cli.stopping import stop_on_signals
from rigrunner.engine import UnattendedAnswers
from rigrunner.queue import SPECIMEN, tested_before
from rigrunner.run.following import following
from rigrunner.run.inputs import answer_inputs
from rigrunner.run.record import execute
from rigrunner.run.taping import mark_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.events import EventSink
    from rigrunner.engine import Interference, Override
    from rigrunner.run.finish import FinishedRun
    from rigrunner.run.left_energised import Person
    from rigrunner.run.prepare import Planned


def attended_run(
    planned: Planned,
    known_inputs: Mapping[str, str],
    *,
    runs: Path,
    partners: Mapping[str, Path],
    operator: str,
    unattended: bool,
    person: Person,
    overrides: Sequence[Override] = (),
    listeners: Sequence[EventSink] = (),
    before: Sequence[Interference] = (),
) -> FinishedRun:
    """Ask for the missing inputs and execute the run; raises as `execute`.

    `unattended`: take the unattended answers of the procedure; pausing is not possible.
    """
    with (
        stop_on_signals(attended=not unattended) as stop,
        shown_progress() as progress,
        planned.tape or nullcontext(),
        following(planned, progress.live) as live,
    ):
        answers = UnattendedAnswers() if unattended else TerminalAnswers(stop, progress)
        inputs = answer_inputs(planned.procedure, known_inputs, answers)
        if not before and not mark_of(planned.tape):  # an entry of the queue says why, if it is
            specimens = [inputs.get(SPECIMEN, "")]
            for note in tested_before(runs, planned.procedure.model.id, specimens).values():
                message(f"note: {note}")
        person_name = operator or inputs.get("operator", answers.by)
        return execute(
            planned,
            runs=runs,
            inputs=inputs,
            partners=partners,
            answers=answers,
            stop=stop,
            listeners=[stop, progress, *live, *listeners],
            operator=operator,
            overrides=overrides,
            pauses=None if unattended else TerminalPauses(stop, progress, person_name),
            progress=progress.analysing,
            person=person,
            before=before,
        )
