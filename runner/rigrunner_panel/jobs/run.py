"""Does a run as the command line does, with the panel in place of the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.queue import Queue
from rigrunner.run.following import following
from rigrunner.run.inputs import answer_inputs, with_operator
from rigrunner.run.interrupted import read_interrupted
from rigrunner.run.partners import partners_for
from rigrunner.run.planning import planned_run
from rigrunner.run.record import execute
from rigrunner.run.resume import prepare_resume, resume, run_files
from rigrunner.runfile import run_lock
from rigrunner.tools.by_hand.settling import settle_left
from rigrunner_panel.jobs.overriding import overrides_of
from rigrunner_panel.process.messages import Ended, Found
from rigrunner_panel.process.person import PanelAnswers, PanelPauses, PanelPerson
from rigrunner_panel.process.watched import WatchedChannels
from rigrunner_panel.view.channels import channels_of
from rigrunner_panel.view.of_plan import plan_view
from rigrunner_panel.view.of_result import finished_view, live_view
from rigrunner_panel.view.sections import AnalysingView

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.api.findings import Findings
    from rigrunner.run.finish import FinishedRun
    from rigrunner.run.prepare import Planned
    from rigrunner_panel.process.link import Link
    from rigrunner_panel.process.messages import Job


def run(job: Job, link: Link) -> Ended:
    """Do the run, or resume it; raise what keeps it from starting."""
    finished = _resumed(job, link) if job.resumes else _done(job, link)
    view = None if finished.result is None else live_view(finished.result, final=True)
    return Ended(finished_view(finished), view)


def _done(job: Job, link: Link) -> FinishedRun:
    planned = planned_run(job.procedure, job.station, realtime=job.view.realtime)
    screen = _Screen(job, link, planned)
    settle_left(job.station, screen.person)
    overrides = tuple(overrides_of(planned, job))
    partners = partners_for(planned, job.runs, job.partners)
    screen.begin(partners)
    queue = Queue(job.runs)
    entry = None if job.entry is None else queue.get(job.entry)
    operator = job.view.operator
    given = with_operator(job.view.inputs, operator or None, planned.procedure)
    with following(planned, screen.show) as live:
        return execute(
            planned,
            runs=job.runs,
            inputs=answer_inputs(planned.procedure, given, screen.answers),
            partners=partners,
            answers=screen.answers,
            stop=link.switch,
            listeners=[
                link.switch,
                *([queue.began(entry.id)] if entry else []),
                link.sender,
                *live,
            ],
            operator=operator,
            overrides=overrides,
            pauses=screen.pauses,
            person=screen.person,
            told=entry.told() if entry else (),
            progress=screen.progress,
        )


def _resumed(job: Job, link: Link) -> FinishedRun:
    folder = job.runs / job.view.run
    with run_lock(folder):
        stored = read_interrupted(folder)
        files = run_files(stored, job.procedure, job.station)
        planned = planned_run(*files, realtime=job.view.realtime)
        found = prepare_resume(folder, stored, planned, job.view.operator)
        screen = _Screen(job, link, planned)
        settle_left(job.station, screen.person)
        screen.begin(found.partners)
        with following(planned, screen.show) as live:
            return resume(
                found,
                answers=screen.answers,
                stop=link.switch,
                listeners=[link.switch, link.sender, *live],
                pauses=screen.pauses,
                progress=screen.progress,
                person=screen.person,
            )


class _Screen:
    """What a run is told at the panel and shows there, in place of a terminal."""

    def __init__(self, job: Job, link: Link, planned: Planned) -> None:
        operator = job.view.operator
        self._job = job
        self._link = link
        self._planned = planned
        watched = WatchedChannels(link.sender.send_unless_behind, planned.devices)
        self.person = PanelPerson(link.sender, planned.clock, operator)
        self.answers = PanelAnswers(link, operator, watched)
        self.pauses = PanelPauses(link, watched)

    def begin(self, partners: Mapping[str, Path]) -> None:
        """Show what is about to run."""
        taken = tuple(each.name for each in partners.values())
        known = {"title": self._planned.procedure.model.title, "partners": taken}
        self._link.show(
            job=self._job.view.model_copy(update=known),
            plan=plan_view(self._planned.plan),
            channels=tuple(channels_of(self._planned)),
        )

    def show(self, found: Findings, *, is_whole: bool) -> None:  # noqa: ARG002  (a screen is told both)
        """Show what the analyses find."""
        self._link.sender.send(Found(found))

    def progress(self, what: str, done: int, of: int) -> None:
        """Show how far the analysis is."""
        self._link.show(analysing=AnalysingView(what=what, done=done, of=of))
