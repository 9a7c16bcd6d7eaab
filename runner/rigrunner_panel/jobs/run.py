"""Does a run as the command line does, with the panel in place of the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.queue import Queue
from rigrunner.run.inputs import answer_inputs, with_operator
from rigrunner.run.interrupted import read_interrupted
from rigrunner.run.partners import partners_for
from rigrunner.run.planning import planned_run
from rigrunner.run.record import execute
from rigrunner.run.resume import prepare_resume, resume, run_files
from rigrunner.runfile import run_lock
from rigrunner.tools.by_hand.settling import settle_left
from rigrunner_panel.jobs.overrides import overrides_of
from rigrunner_panel.jobs.screen import Screen
from rigrunner_panel.process.messages import Ended
from rigrunner_panel.view.result import finished_view, live_view

if TYPE_CHECKING:
    from rigrunner.run.finish import FinishedRun
    from rigrunner_panel.process.link import Link
    from rigrunner_panel.process.messages import Job


def run(job: Job, link: Link) -> Ended:
    """Do the run, or resume it; raise what keeps it from starting."""
    finished = _resumed_run(job, link) if job.resumes else _new_run(job, link)
    view = None if finished.result is None else live_view(finished.result, final=True)
    return Ended(finished_view(finished), view)


def _new_run(job: Job, link: Link) -> FinishedRun:
    planned = planned_run(job.procedure, job.station, realtime=job.view.realtime)
    screen = Screen(job, link, planned)
    settle_left(job.station, screen.person)
    overrides = tuple(overrides_of(planned, job))
    partners = partners_for(planned, job.runs, job.partners)
    screen.begin(planned.plan, partners)
    queue = Queue(job.runs)
    entry = None if job.entry is None else queue.get(job.entry)
    operator = job.view.operator
    inputs = with_operator(job.view.inputs, operator or None, planned.procedure)
    return execute(
        planned,
        runs=job.runs,
        inputs=answer_inputs(planned.procedure, inputs, screen.answers),
        partners=partners,
        answers=screen.answers,
        stop=link.switch,
        listeners=[link.switch, *([queue.began(entry.id)] if entry else []), link.sender],
        operator=operator,
        overrides=overrides,
        pauses=screen.pauses,
        person=screen.person,
        before=entry.remarks() if entry else (),
        progress=screen.progress,
    )


def _resumed_run(job: Job, link: Link) -> FinishedRun:
    folder = job.runs / job.view.run
    with run_lock(folder):
        stored = read_interrupted(folder)
        files = run_files(stored, job.procedure, job.station)
        planned = planned_run(*files, realtime=job.view.realtime)
        prepared = prepare_resume(folder, stored, planned, job.view.operator)
        screen = Screen(job, link, planned)
        settle_left(job.station, screen.person)
        screen.begin(planned.plan, prepared.partners)
        return resume(
            prepared,
            answers=screen.answers,
            stop=link.switch,
            listeners=[link.switch, link.sender],
            pauses=screen.pauses,
            progress=screen.progress,
            person=screen.person,
        )
